# SPDX-License-Identifier: MIT
"""Selections and points of surfaces."""
import json

import numpy as np
import pytest

from conftest import PLUSH, ROOT


def wall(quadsplat, context, opacity=0.999):
    """Flat Gaussians on z = 4, 0.3 apart."""
    y, x = np.mgrid[-8:9, -10:11] * 0.3
    count = x.size
    means = np.column_stack([x.ravel(), y.ravel(), np.full(count, 4.0)])
    return quadsplat.Scene.from_arrays(
        means, np.tile([0.3, 0.3, 0.0], (count, 1)), np.tile([1.0, 0, 0, 0], (count, 1)),
        np.full(count, opacity), colors=np.full((count, 3), 0.5), context=context), means


def test_selections_are_those_of_an_independent_program(scene):
    steps = json.loads((ROOT / "tests/golden/selections.edits.json").read_text())["steps"]
    for end in range(1, len(steps) + 1):
        assert scene.select(*steps[:end]).sum() == steps[end - 1]["count"]
    assert scene.edit(ROOT / "tests/golden/selections.edits.json").selected.all()


def test_numbers_cameras_and_arrays_are_members(quadsplat, cpu):
    scene, means = wall(quadsplat, cpu)
    camera = quadsplat.Camera(90, 60, 80, view_from_world=np.eye(4))
    point = np.array([0.3, 0.0, 4.0])
    near = np.linalg.norm(means - point, axis=1) <= 0.61
    assert np.array_equal(scene.select(tool="sphere", point=point, radius=np.float32(0.61)), near)
    pixels = means[:, :2] / 4 * 80 + [44.5, 29.5]
    inside = ((pixels >= [30, 20]) & (pixels < [60, 40])).all(axis=1)
    box = [(30, 20), (60, 40)]
    assert np.array_equal(
        scene.select(tool="rectangle", camera=camera, pixels=box, kind="through"), inside)
    visible = scene.select(tool="rectangle", camera=camera, pixels=box)
    touching = scene.select(tool="rectangle", camera=camera, pixels=box, kind="touching")
    assert visible.any() and (touching >= visible).all() and touching.sum() > visible.sum()
    # Behind what is removed, everything is visible.
    end = scene.edit([{"tool": "rectangle", "camera": camera, "pixels": box, "kind": "touching"},
                      {"step": "hide"}, {"tool": "all"}])
    assert np.array_equal(end.left, ~touching) and np.array_equal(end.selected, ~touching)


def test_gaussians_that_are_not_drawn_keep_their_numbers_and_are_not_selected(quadsplat, cpu):
    arrays = {"means": [[0, 0, 1], [np.nan, 0, 1], [0, 0, 3]], "scales": np.ones((3, 3)),
              "rotations": [[1, 0, 0, 0]] * 3, "opacities": np.ones(3), "colors": np.ones((3, 3))}
    scene = quadsplat.Scene.from_arrays(**arrays, context=cpu)
    assert scene.select(tool="all").tolist() == [True, False, True]
    assert scene.select(tool="distance", point=(0, 0, 0), low=2).tolist() == [False, False, True]


def test_steps_that_do_not_fit_are_refused(quadsplat, scene, tmp_path):
    def refused(call, kind):
        with pytest.raises(kind) as raised:
            call()
        return str(raised.value)

    assert refused(lambda: scene.select(), quadsplat.UsageError).startswith("Scene.select: no step was given")
    assert refused(lambda: scene.select(7), quadsplat.UsageError).startswith("Scene.select: 7 is no mapping")
    assert refused(lambda: scene.select(tool="wand"), quadsplat.InputError).startswith(
        "edits: step 1: tool is 'wand', which is none of rectangle, ")
    assert "step 1: radius is missing" in refused(
        lambda: scene.select(tool="sphere", point=(0, 0, 0)), quadsplat.InputError)
    assert refused(lambda: scene.select(tool="opacity", low=float("nan")), quadsplat.UsageError)
    assert refused(lambda: scene.edit(tmp_path / "missing.json"), quadsplat.InputError)
    assert "they are of a scene of 5 Gaussians" in refused(
        lambda: scene.edit(written(tmp_path, '{"version": 1, "scene": {"gaussians": 5}, "steps": []}')),
        quadsplat.InputError)


def written(folder, text):
    (folder / "a.edits.json").write_text(text)
    return folder / "a.edits.json"


def test_points_are_on_the_wall_with_their_distances(quadsplat, cpu):
    scene, _ = wall(quadsplat, cpu)
    camera = quadsplat.Camera(90, 60, 80, view_from_world=np.eye(4))
    points = quadsplat.measure(scene, camera, [(44, 30), (64, 30), (64, 10)])
    for point in points:
        assert point.position[2] == pytest.approx(4, abs=1e-5)
        assert point.position == pytest.approx(point.distance * point.direction)
        assert point.along < 1e-5 and point.across == pytest.approx(point.distance / 80 / 12**0.5)
    assert np.linalg.norm(points[1].position - points[0].position) == pytest.approx(1, abs=1e-5)
    assert points[0].to_next == pytest.approx(np.hypot(points[0].across, points[1].across), rel=0.05)
    assert np.isnan(points[2].to_next)
    faint, _ = wall(quadsplat, cpu, opacity=0.01)
    assert quadsplat.measure(faint, camera, [(44, 30)]) == [None]
    assert quadsplat.measure(scene, camera, np.zeros((0, 2))) == []


def test_pixels_outside_of_the_picture_are_refused(quadsplat, scene, camera):
    for pixels in ([(-1, 0)], [(0, 101)], [(150, 0)], [(2**40, 3)]):
        with pytest.raises(quadsplat.UsageError, match="outside of the picture of 150 x 101"):
            quadsplat.measure(scene, camera, pixels)
    for pixels in ([1, 2], [(0.5, 1)], [(1, 2, 3)], [(float("nan"), 1)]):
        with pytest.raises(quadsplat.UsageError, match="no list of whole numbers"):
            quadsplat.measure(scene, camera, pixels)


def test_measures_are_those_of_the_program(quadsplat, scene, camera, program, tmp_path):
    program("measure", PLUSH, "--backend", "cpu", "--camera-index", 32, "--size", "150x101", "--pixels", "75,50",
            "80,60", "--json", tmp_path / "a.json")
    said = json.loads((tmp_path / "a.json").read_text())
    points = quadsplat.measure(scene, camera, [(75, 50), (80, 60)])
    assert said["points"][1]["position"] == pytest.approx(points[1].position.tolist())
    assert said["distances"][0]["error"] == pytest.approx(points[0].to_next)
