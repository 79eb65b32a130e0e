# SPDX-License-Identifier: MIT
"""Scenes from files and from arrays."""
import gc
import pickle

import numpy as np
import pytest

from conftest import PLUSH


def test_facts_describe_the_file(scene):
    facts = scene.facts
    assert len(scene) == facts.gaussians == 34321 and facts.not_drawn == 0
    assert facts.format.startswith("ply") and facts.path == str(PLUSH)
    assert facts.file_bytes == PLUSH.stat().st_size and facts.axes == "RDF"
    assert 0 <= facts.sh_degree <= 3 and facts.warnings == ()
    low, high = scene.bounds
    assert low.shape == high.shape == (3,) and (low < high).all()
    assert len(scene.cameras()) == 97
    assert "plush.ply: 34321 Gaussians" in repr(scene)


def test_a_scene_of_arrays_is_the_scene_of_the_file(quadsplat, scene, camera, cpu, tmp_path):
    quadsplat.convert(scene, tmp_path / "a.ply")
    data = (tmp_path / "a.ply").read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    names = [line.split()[2] for line in data[:end].decode().splitlines()
             if line.startswith("property float")]
    rows = np.frombuffer(data[end:], np.float32).reshape(-1, len(names))
    column = {name: i for i, name in enumerate(names)}

    def columns(*wanted):
        return rows[:, [column[name] for name in wanted]]

    rest = [name for name in names if name.startswith("f_rest")]
    count = len(rest) // 3
    dc = columns("f_dc_0", "f_dc_1", "f_dc_2")[:, None, :]
    higher = columns(*rest).reshape(-1, 3, count).transpose(0, 2, 1)
    raw = {"means": columns("x", "y", "z"), "scales": columns("scale_0", "scale_1", "scale_2"),
           "rotations": columns("rot_0", "rot_1", "rot_2", "rot_3"),
           "opacities": columns("opacity"), "activated": False, "context": cpu}
    expected = quadsplat.render(scene, camera).color
    for colors in ({"sh": dc, "sh_rest": higher}, {"sh": np.concatenate([dc, higher], 1)}):
        wrapped = quadsplat.Scene.from_arrays(**raw, **colors)
        assert np.array_equal(quadsplat.render(wrapped, camera).color, expected)
    activated = quadsplat.Scene.from_arrays(
        raw["means"], np.exp(raw["scales"].astype(np.float64)), raw["rotations"],
        1 / (1 + np.exp(-raw["opacities"].astype(np.float64))), dc, sh_rest=higher, context=cpu)
    assert quadsplat.render(activated, camera).psnr(expected) > 70


def test_arrays_of_a_scene_make_the_same_scene(quadsplat, scene, camera, cpu):
    expected = quadsplat.render(scene, camera).color
    count, degree = len(scene), scene.facts.sh_degree
    shapes = {"means": (count, 3), "scales": (count, 3), "rotations": (count, 4),
              "opacities": (count,), "sh": (count, (degree + 1) ** 2, 3)}
    antialiased = scene.facts.antialiased
    for dtype in ("float32", np.float64):
        raw = scene.arrays(activated=False, dtype=dtype)
        assert {name: array.shape for name, array in raw.items()} == shapes
        assert list(raw) == list(shapes)
        assert {array.dtype for array in raw.values()} == {np.dtype(dtype)}
        again = quadsplat.Scene.from_arrays(**raw, activated=False, antialiased=antialiased,
                                            context=cpu)
        assert np.array_equal(quadsplat.render(again, camera).color, expected)
    values = scene.arrays()
    with np.errstate(over="ignore"):
        assert np.allclose(values["scales"], np.exp(raw["scales"]), rtol=1e-6, atol=0)
        assert np.allclose(values["opacities"], 1 / (1 + np.exp(-raw["opacities"])), rtol=1e-6)
    again = quadsplat.Scene.from_arrays(**values, antialiased=antialiased, context=cpu)
    assert quadsplat.render(again, camera).psnr(expected) > 70


def test_arrays_of_a_scene_are_drawn_by_the_differentiable_rasterizer(quadsplat, scene, camera):
    torch = pytest.importorskip("torch")
    from quadsplat.torch import rasterize

    values = {name: torch.from_numpy(array) for name, array in scene.arrays().items()}
    drawn = rasterize(**values, camera=camera).color.numpy()
    expected = quadsplat.render(scene, camera, background=(0, 0, 0))
    assert expected.psnr(drawn) > 60


def test_arrays_of_gaussians_that_are_not_drawn_are_nan(quadsplat, one, cpu):
    spoilt = one(means=[[0, 0, 2]] * 3, scales=[[1, 1, 1], [1, -1, 1], [1, 1, 2]],
                 rotations=[[2, 0, 0, 0]] * 3, opacities=[0.5] * 3, colors=[[0.5, 0.5, 0.5]] * 3)
    values = spoilt.arrays(dtype="float64")
    for name, array in values.items():
        assert np.isnan(array[1]).all() and np.isfinite(array[[0, 2]]).all(), name
    assert values["rotations"][0].tolist() == [1, 0, 0, 0] and values["sh"][0].tolist() == [[0] * 3]
    assert values["scales"][2] == pytest.approx([1, 1, 2]) and values["opacities"][2] == 0.5
    again = quadsplat.Scene.from_arrays(**values, context=cpu)
    assert len(again) == 3 and again.facts.not_drawn == 1


def test_arrays_are_refused_with_a_sentence(quadsplat, one):
    scene = one()
    for dtype in ("uint8", "float16", "best", [3]):
        with pytest.raises(quadsplat.UsageError) as raised:
            scene.arrays(dtype=dtype)
        assert str(raised.value) == (
            f"Scene.arrays: dtype: {dtype!r} is none of 'float32', 'float64'")
    scene.close()
    with pytest.raises(quadsplat.UsageError, match="^Scene.arrays: the scene was closed$"):
        scene.arrays()
    with quadsplat.Context("cpu", threads=1) as context:
        other = one(context=context)
    with pytest.raises(quadsplat.UsageError, match="^Scene.arrays: the context was closed$"):
        other.arrays()


def test_rgb_colours_are_drawn_as_they_are(quadsplat, one):
    scene = one(opacities=[1], scales=[[9, 9, 9]], means=[[0, 0, 5]], colors=[[0.25, 0.5, 2]])
    pixel = quadsplat.render(scene, quadsplat.Camera(3, 3, 9)).color[1, 1]
    assert pixel == pytest.approx(np.array([0.25, 0.5, 2]) * 0.99, rel=1e-5)


def test_gaussians_that_cannot_be_drawn_keep_the_numbers_of_others(quadsplat, cpu):
    nan, inf = float("nan"), float("inf")
    count = 6
    means = np.tile([0.0, 0.0, 2.0], (count, 1))
    scales = np.full((count, 3), 0.1)
    rotations = np.tile([1.0, 0, 0, 0], (count, 1))
    opacities = np.full(count, 0.5)
    means[0, 1], scales[1, 0], rotations[2], opacities[3], scales[4, 2] = nan, -1, 0, 1.5, inf
    scene = quadsplat.Scene.from_arrays(means, scales, rotations, opacities,
                                        colors=np.ones((count, 3)), context=cpu)
    assert len(scene) == count and scene.facts.not_drawn == 5
    lists = quadsplat.tile_lists(scene, quadsplat.Camera(16, 16, 20))
    assert list(lists.gaussians) == [5] and list(lists.listed) == [5]


def test_a_scene_may_be_empty(quadsplat, cpu):
    empty = quadsplat.Scene.from_arrays(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 4)),
                                        np.zeros(0), np.zeros((0, 4, 3)), context=cpu)
    assert len(empty) == 0 and empty
    picture = quadsplat.render(empty, quadsplat.Camera(5, 4, 3), outputs=["color", "depth"],
                               background=(0, 0.5, 1))
    assert (picture.color == np.float32([0, 0.5, 1])).all() and (picture.depth == 0).all()
    assert [array.shape for array in empty.arrays().values()] == [
        (0, 3), (0, 3), (0, 4), (0,), (0, 4, 3)]
    with pytest.raises(quadsplat.UsageError, match="^convert: .*no Gaussian"):
        quadsplat.convert(empty, "unused.ply")


@pytest.mark.parametrize("ending", [".ply", ".compressed.ply", ".spz", ".splat", ".glb"])
def test_scenes_are_converted(quadsplat, scene, camera, tmp_path, ending):
    path = tmp_path / f"a{ending}"
    quadsplat.convert(PLUSH, path)
    again = quadsplat.load(path, context=scene.context)
    assert len(again) == len(scene)
    assert quadsplat.render(again, camera).psnr(quadsplat.render(scene, camera)) > 25
    with pytest.raises(quadsplat.UsageError, match="overwrite"):
        quadsplat.convert(scene, path)
    quadsplat.convert(scene, path, keep_largest=100, sh_degree=0, overwrite=True)
    assert len(quadsplat.load(path, context=scene.context)) == 100


def test_a_conversion_leaves_out_what_is_outside_of_a_box(quadsplat, scene, program, tmp_path):
    box = [[-3, -2, -4], [3, 4, 4.5]]
    quadsplat.convert(scene, tmp_path / "a.ply", crop=box, drop_floaters=True)
    program("convert", PLUSH, tmp_path / "b.ply", "--crop", "-3,-2,-4,3,4,4.5",
            "--drop-floaters")
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()
    less = quadsplat.load(tmp_path / "a.ply", context=scene.context)
    assert 0 < len(less) < len(scene)
    assert (less.bounds[0] >= box[0]).all() and (less.bounds[1] <= box[1]).all()
    for wrong, sentence in [([[0, 0, 0], [0, 0, 0]], "convert: crop is a box without size"),
                            (box[::-1], "convert: crop_low: 3 is not at most crop_high -3 and"),
                            ([1, 2], "convert: crop has the shape (2,) instead of (2, 3)")]:
        with pytest.raises(quadsplat.UsageError) as error:
            quadsplat.convert(scene, tmp_path / "c.ply", crop=wrong)
        assert str(error.value).startswith(sentence)
    assert not (tmp_path / "c.ply").exists()


def test_a_conversion_equals_the_program(quadsplat, program, tmp_path):
    program("convert", PLUSH, tmp_path / "program.spz")
    quadsplat.convert(PLUSH, tmp_path / "package.spz")
    assert (tmp_path / "package.spz").read_bytes() == (tmp_path / "program.spz").read_bytes()


def test_closed_scenes_and_contexts_are_refused(quadsplat, one):
    camera = quadsplat.Camera(8, 8, 8)
    scene = one()
    scene.close()
    scene.close()
    with pytest.raises(quadsplat.UsageError, match="^render: the scene was closed$"):
        quadsplat.render(scene, camera)
    assert "closed" in repr(scene)
    with quadsplat.Context("cpu", threads=1) as context:
        with one(context=context) as inner:
            quadsplat.render(inner, camera)
        other = one(context=context)
    for act in (lambda: quadsplat.render(other, camera), lambda: one(context=context)):
        with pytest.raises(quadsplat.UsageError, match="the context was closed"):
            act()
    assert "closed" in repr(context)
    other.close()


def test_scenes_and_contexts_that_nothing_refers_to_are_freed(quadsplat, one):
    def resident():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * 4096

    camera = quadsplat.Camera(64, 64, 64)

    def work(times):
        for _ in range(times):
            context = quadsplat.Context("cpu", threads=2)
            scene = one(context=context, means=np.zeros((20000, 3)) + [0, 0, 2],
                        scales=np.ones((20000, 3)), rotations=np.ones((20000, 4)),
                        opacities=np.full(20000, 0.01), colors=np.ones((20000, 3)))
            quadsplat.tile_lists(scene, camera)
        gc.collect()

    work(10)
    before = resident()
    work(60)
    assert resident() - before < 30e6


def test_scenes_are_not_pickled_or_made_directly(quadsplat, scene):
    for act in (lambda: pickle.dumps(scene), lambda: pickle.dumps(scene.context),
                lambda: quadsplat.Scene()):
        with pytest.raises(quadsplat.UsageError):
            act()


def test_sentences_about_a_file_are_warnings(quadsplat, cpu, tmp_path):
    data = PLUSH.read_bytes()
    (tmp_path / "long.ply").write_bytes(data + b"abc")
    with pytest.warns(UserWarning, match="long.ply: 3 bytes") as caught:
        scene = quadsplat.load(tmp_path / "long.ply", context=cpu)
    assert len(scene.facts.warnings) == 1 and caught[0].filename == __file__
    with pytest.raises(quadsplat.InputError, match="no file of cameras"):
        scene.cameras()
