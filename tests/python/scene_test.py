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
