# SPDX-License-Identifier: MIT
"""Pictures are those of the program, in every mode and form."""
import numpy as np
import pytest

from conftest import PLUSH

SIZE = "150x101"
QUANTITIES = {"color": "color", "alpha": "alpha", "depth": "depth", "median_depth": "median-depth"}


@pytest.mark.parametrize("pipeline", ["fast", "classic"])
def test_pictures_equal_those_of_the_program_in_every_mode(quadsplat, scene, camera, program,
                                                           tmp_path, pipeline):
    for word in QUANTITIES.values():
        program("render", PLUSH, "--backend", "cpu", "--camera-index", 32, "--size", SIZE, "--cull",
                "all,+peers", "--repeats", 1, "--pipeline", pipeline, "--picture", word, "--output",
                tmp_path / f"{word}.npy")
    names = [mode.name for mode in quadsplat.modes()][1:]
    assert len(names) >= 6
    for mode in names:
        picture = quadsplat.render(scene, camera, outputs=list(QUANTITIES), cull=mode,
                                   pipeline=pipeline)
        for name, word in QUANTITIES.items():
            expected = np.load(tmp_path / f"{word}_{mode}.npy")
            array = getattr(picture, name)
            assert array.dtype == np.float32 and array.flags.c_contiguous
            assert np.array_equal(array, expected.reshape(array.shape)), (mode, name)
        assert picture.cull == mode and picture.counts.pipeline == pipeline


def test_settings_are_those_of_the_program(quadsplat, scene, camera, program, tmp_path):
    program("render", PLUSH, "--backend", "cpu", "--camera-index", 32, "--size", SIZE,
            "--background", "0.25,0.5,1", "--splat-scale", "0.5", "--sh-degree", 0, "--antialiased",
            "on", "--tile-size", 8, "--output", tmp_path / "a.npy")
    picture = quadsplat.render(scene, camera, background=(0.25, 0.5, 1), splat_scale=0.5,
                               sh_degree=0, antialiased=True, tile_px=8)
    assert np.array_equal(picture.color, np.load(tmp_path / "a.npy"))
    usual = quadsplat.render(scene, camera)
    assert not np.array_equal(picture.color, usual.color)
    assert quadsplat.Settings() == quadsplat.Settings(**quadsplat.Settings()._asdict())
    again = quadsplat.render(scene, camera, **quadsplat.Settings()._asdict())
    assert np.array_equal(again.color, usual.color)


def test_the_reference_mode_draws_without_tile_lists(quadsplat, one):
    camera = quadsplat.Camera(40, 30, 50)
    scene = one()
    reference = quadsplat.render(scene, camera, cull="reference")
    assert quadsplat.render(scene, camera).psnr(reference) > 80
    with pytest.raises(quadsplat.UsageError, match="mode reference has no tile lists"):
        quadsplat.render(scene, camera, cull="reference", outputs="pairs")


def test_outputs_are_computed_only_if_asked_for(quadsplat, scene, camera):
    everything = ["color", "alpha", "depth", "median_depth", "evaluated", "pairs", "used"]
    whole = quadsplat.render(scene, camera, outputs=everything)
    for name in everything:
        part = quadsplat.render(scene, camera, outputs=name)
        assert np.array_equal(getattr(part, name), getattr(whole, name)), name
        assert [other for other in everything if getattr(part, other) is not None] == [name]
    nothing = quadsplat.render(scene, camera, outputs=())
    assert nothing.color is None and nothing.counts.tile_pairs == whole.counts.tile_pairs
    counts = whole.counts
    assert whole.pairs.shape == (counts.tile_rows, counts.tile_columns) == (7, 10)
    assert whole.pairs.sum() == counts.tile_pairs and whole.pairs.max() == counts.max_pairs_in_a_tile
    assert whole.used.sum() == counts.used_pairs <= counts.tile_pairs
    assert whole.evaluated.shape == (101, 150) and whole.evaluated.max() > 0
    assert 0 < counts.visible <= counts.gaussians == len(scene)
    assert set(counts.stage_ms) == {"preprocess", "bin", "sort", "blend"} and counts.frame_ms > 0


def test_eight_bits_are_rounded_from_floats(quadsplat, scene, camera):
    for dtype in ("uint8", np.uint8, np.dtype("uint8")):
        bytes_of = quadsplat.render(scene, camera, outputs=["color", "alpha"], dtype=dtype)
        assert bytes_of.color.dtype == bytes_of.alpha.dtype == np.uint8
    floats = quadsplat.render(scene, camera, outputs=["color", "alpha"])
    for name in ("color", "alpha"):
        scaled = np.floor(np.float32(255) * np.clip(getattr(floats, name), 0, 1) + np.float32(0.5))
        assert np.array_equal(getattr(bytes_of, name), scaled.astype(np.uint8))


def test_several_cameras_give_a_list(quadsplat, scene):
    cameras = [camera.resized(60 + i, 40) for i, camera in enumerate(scene.cameras()[:3])]
    pictures = quadsplat.render(scene, cameras, outputs=["color", "pairs"])
    assert [picture.color.shape for picture in pictures] == [(40, 60, 3), (40, 61, 3), (40, 62, 3)]
    for camera, picture in zip(cameras, pictures):
        assert picture.camera == camera
        assert np.array_equal(picture.color, quadsplat.render(scene, camera).color)
    assert quadsplat.render(scene, []) == []
    assert len(quadsplat.render(scene, (camera for camera in cameras))) == 3


def test_pictures_own_their_arrays(quadsplat, one):
    camera = quadsplat.Camera(20, 10, 20)
    first = quadsplat.render(one(), camera)
    kept = first.color.copy()
    quadsplat.render(one(colors=[[0, 0, 1]]), camera)
    assert np.array_equal(first.color, kept)
    assert first.color.flags.owndata and first.color.flags.writeable


def test_a_model_decides_the_background_unless_it_is_given(quadsplat, scene, cpu, tmp_path):
    folder = tmp_path / "model"
    (folder / "point_cloud/iteration_7").mkdir(parents=True)
    quadsplat.convert(scene, folder / "point_cloud/iteration_7/point_cloud.ply")
    (folder / "cfg_args").write_text("Namespace(sh_degree=3, white_background=True)")
    white = quadsplat.load(folder, context=cpu)
    assert white.facts.white_background
    away = quadsplat.Camera.look_at((0, 0, 1000), (0, 0, 2000), 8, 8)
    assert (quadsplat.render(white, away).color == 1).all()
    assert (quadsplat.render(white, away, background=(0, 0, 0)).color == 0).all()
    assert (quadsplat.render(scene, away).color == 0).all()


def test_the_older_name_of_cull_is_taken_with_a_note(quadsplat, scene, camera):
    with pytest.warns(DeprecationWarning, match="render: mode is called cull now"):
        picture = quadsplat.render(scene, camera, mode="3dgs")
    assert picture.cull == "3dgs"
    assert (picture.color == quadsplat.render(scene, camera, cull="3dgs").color).all()
