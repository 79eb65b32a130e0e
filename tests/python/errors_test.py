# SPDX-License-Identifier: MIT
"""Every wrong argument gives a sentence that names the function and the argument."""
import numpy as np
import pytest

from conftest import PLUSH


def test_the_exceptions_are_of_one_family(quadsplat):
    assert issubclass(quadsplat.UsageError, (quadsplat.Error, ValueError))
    assert issubclass(quadsplat.InputError, OSError) and issubclass(quadsplat.DeviceError, RuntimeError)
    for kind in ("UsageError", "InputError", "DeviceError", "Cancelled"):
        assert issubclass(getattr(quadsplat, kind), quadsplat.Error)
        assert getattr(quadsplat, kind)("a sentence").args == ("a sentence",)


@pytest.mark.parametrize("options, sentence", [
    ({"cull": "best"}, "render: cull: 'best' is none of reference, 3dgs, "),
    ({"backend": "cpu"}, "render: backend is not a setting: the scene's context has it: "),
    ({"cull": "3dgs", "mode": "3dgs"}, "render: give cull alone: mode is its older name"),
    ({"cull": 3}, "render: cull is 3 instead of a text"),
    ({"cull": "a\0b"}, "render: cull has a character of code 0"),
    ({"pipeline": "slow"}, "render: pipeline: 'slow' is none of 'fast', 'classic'"),
    ({"background": (1, 2)}, "render: background is (1, 2) instead of 3 numbers"),
    ({"background": "red"}, "render: background is 'red' instead of 3 numbers"),
    ({"background": (0, float("nan"), 0)}, "render: background: is not finite"),
    ({"splat_scale": 0}, "render: splat_scale: 0 is not between 1e-06 and 1e+06"),
    ({"splat_scale": float("nan")}, "render: splat_scale: nan is not between"),
    ({"splat_scale": "1m"}, "render: splat_scale is '1m' instead of a number"),
    ({"dilation_px2": -1}, "render: dilation_px2: -1 is not between 0 and 1e+06"),
    ({"sh_degree": 4}, "render: sh_degree: 4 is not between 0 and 3"),
    ({"sh_degree": 1.5}, "render: sh_degree is 1.5 instead of an integer"),
    ({"antialiased": "yes"}, "render: antialiased: 'yes' is none of None, True, False"),
    ({"antialiased": []}, "render: antialiased: [] is none of None, True, False"),
    ({"tile_px": 10}, "render: tile_px: 10 is not 8, 16 or 32"),
    ({"tile_px": 2**40}, "render: tile_px: 1099511627776 is not between 1 and 65535"),
    ({"dtype": "float64"}, "render: dtype: 'float64' is none of 'float32', 'uint8'"),
    ({"dtype": [3]}, "render: dtype: [3] is none of 'float32', 'uint8'"),
    ({"outputs": "colour"}, "render: outputs: 'colour' is none of color, alpha, "),
    ({"outputs": 3}, "render: outputs is 3 instead of words"),
    ({"culling": "3dgs"}, "render: there is no setting 'culling': the settings are cull, ")])
def test_wrong_settings(quadsplat, one, options, sentence):
    with pytest.raises(quadsplat.UsageError) as raised:
        quadsplat.render(one(), quadsplat.Camera(8, 8, 8), **options)
    assert str(raised.value).startswith(sentence)


def test_wrong_scenes_and_cameras(quadsplat, one, camera):
    scene = one()
    for act, sentence in [
            (lambda: quadsplat.render("plush.ply", camera),
             "render: scene is str instead of a quadsplat.Scene"),
            (lambda: quadsplat.render(scene, None), "render: cameras is None"),
            (lambda: quadsplat.render(scene, [camera, 3]),
             "render: cameras[1] is int instead of a quadsplat.Camera"),
            (lambda: quadsplat.tile_lists(scene, [camera]),
             "tile_lists: camera is list instead of a quadsplat.Camera"),
            (lambda: quadsplat.counts(scene, camera, cull="3dgs"),
             "counts: cull is not a setting here: every mode is counted"),
            (lambda: quadsplat.counts(scene, camera, tile_px=7), "counts: tile_px: 7 is not"),
            (lambda: quadsplat.load(3), "load: path is 3 instead of a path"),
            (lambda: quadsplat.load(PLUSH, axes="XYZ"), ""),
            (lambda: quadsplat.load(PLUSH, context="cpu"),
             "load: context is 'cpu' instead of a quadsplat.Context"),
            (lambda: quadsplat.convert(scene, "a.ply", sh_degree=9),
             "convert: sh_degree: 9 is not between 0 and 3"),
            (lambda: quadsplat.convert(scene, "a.ply", keep_largest=0),
             "convert: keep_largest: 0 is not between 1 and"),
            (lambda: quadsplat.convert(scene, "a.ply", axes="RDF"),
             "convert: axes belongs to a path, but source is a scene"),
            (lambda: quadsplat.convert(scene, "a.unknown"), "a.unknown: cannot write"),
            (lambda: quadsplat.Context("gpu"),
             "Context: backend: 'gpu' is none of 'auto', 'cpu', 'cuda'"),
            (lambda: quadsplat.Context("cpu", threads=-1), "Context: threads: -1 is not between"),
            (lambda: quadsplat.Context("cpu", device=-2), "Context: device: -2 is not between")]:
        with pytest.raises(quadsplat.UsageError) as raised:
            act()
        assert str(raised.value).startswith(sentence)


def test_files_that_are_missing_or_damaged(quadsplat, cpu, tmp_path):
    cut = tmp_path / "cut.ply"
    cut.write_bytes(PLUSH.read_bytes()[:5000])
    for path in (cut, tmp_path / "none.ply", tmp_path, "\udcff.ply"):
        with pytest.raises(quadsplat.InputError) as raised:
            quadsplat.load(path, context=cpu)
        assert "\n" not in str(raised.value) and str(raised.value)
    with pytest.raises(OSError):
        quadsplat.load(tmp_path / "none.ply", context=cpu)
    with pytest.raises(quadsplat.InputError):
        quadsplat.convert(tmp_path / "none.ply", tmp_path / "a.ply")
    with pytest.raises(quadsplat.UsageError, match="never writes onto its inputs"):
        quadsplat.convert(PLUSH, PLUSH, overwrite=True)


def test_an_error_leaves_scene_and_context_usable(quadsplat, one):
    scene, camera = one(), quadsplat.Camera(8, 8, 8)
    before = quadsplat.render(scene, camera).color
    for _ in range(3):
        with pytest.raises(quadsplat.Error):
            quadsplat.render(scene, camera, cull="best")
    assert np.array_equal(quadsplat.render(scene, camera).color, before)


