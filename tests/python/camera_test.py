# SPDX-License-Identifier: MIT
"""Cameras."""
import json
import math
import pickle

import numpy as np
import pytest

from conftest import ROOT


def test_the_usual_camera_looks_along_z_with_its_axis_in_the_middle(quadsplat):
    camera = quadsplat.Camera(40, 30, 50)
    assert (camera.width, camera.height) == (40, 30) and camera.focal_px == (50, 50)
    assert camera.center_px == (19.5, 14.5) and camera.near_depth == 0.2 and camera.name == ""
    assert np.array_equal(camera.view_from_world, np.eye(4))
    assert np.array_equal(camera.position, [0, 0, 0])


def test_a_gaussian_is_drawn_where_the_camera_projects_it(quadsplat, one):
    scene = one(means=[[0.5, 0.25, 2]], scales=[[0.01, 0.01, 0.01]])
    camera = quadsplat.Camera(60, 50, (40, 80), (30, 20))
    lists = quadsplat.tile_lists(scene, camera)
    assert lists.means_px[0] == pytest.approx([30 + 40 * 0.25, 20 + 80 * 0.125])
    assert lists.depths[0] == 2


def test_matrices_of_colmap_have_their_pixel_centres_at_halves(quadsplat):
    intrinsics = np.array([[50, 0, 20], [0, 60, 15], [0, 0, 1.0]])
    view = np.eye(4)
    view[:3, 3] = 1, 2, 3
    camera = quadsplat.Camera.from_intrinsics(intrinsics, view, 40, 30, name="a.jpg")
    assert camera.center_px == (19.5, 14.5) and camera.focal_px == (50, 60)
    assert camera == quadsplat.Camera(40, 30, (50, 60), None, view[:3], name="a.jpg")
    assert np.array_equal(camera.intrinsics(), intrinsics)
    assert np.array_equal(camera.position, [-1, -2, -3])
    whole = quadsplat.Camera.from_intrinsics(intrinsics, view, 40, 30, pixel_center=0)
    assert whole.center_px == (20, 15)
    assert np.array_equal(whole.intrinsics(pixel_center=0), intrinsics)


def test_look_at_has_the_target_in_the_middle_and_up_upwards(quadsplat):
    eye, target = np.array([1.0, -2, 3]), np.array([4.0, 1, -2])
    for up in [(0, -1, 0), (0, 0, 9), (1e-200, 0, 0), (1e200, 1e200, 0)]:
        camera = quadsplat.Camera.look_at(eye, target, 80, 60, up=up, fov_y_degrees=90)
        assert camera.focal_px == pytest.approx((30, 30))
        assert camera.position == pytest.approx(eye)
        rotation, move = camera.view_from_world[:3, :3], camera.view_from_world[:3, 3]
        assert np.linalg.det(rotation) == pytest.approx(1)
        assert rotation @ target + move == pytest.approx([0, 0, np.linalg.norm(target - eye)])
        above = rotation @ (np.array(up) / np.abs(up).max())
        assert above[1] < 0 and above[0] == pytest.approx(0, abs=1e-12)


def test_cameras_are_read_as_the_file_has_them(quadsplat):
    path = ROOT / "assets" / "cameras.json"
    cameras = quadsplat.read_cameras(path)
    listed = json.loads(path.read_text())
    assert [camera.name for camera in cameras] == [entry["img_name"] for entry in listed]
    for camera, entry in zip(cameras, listed):
        assert (camera.width, camera.height) == (entry["width"], entry["height"])
        assert camera.focal_px == pytest.approx((entry["fx"], entry["fy"]))
        assert camera.position == pytest.approx(entry["position"], abs=1e-5)


def test_the_vertical_field_of_view_survives_another_size(quadsplat, camera):
    tall = camera.resized(10, 2 * camera.height)
    assert (tall.width, tall.height) == (10, 202)
    assert tall.focal_px[1] == pytest.approx(2 * camera.focal_px[1])
    assert tall.name == camera.name and camera.height == 101


def test_cameras_are_compared_hashed_and_pickled(quadsplat, camera):
    other = quadsplat.Camera(camera.width, camera.height, camera.focal_px, camera.center_px,
                             camera.view_from_world, camera.near_depth, camera.name)
    assert other == camera and hash(other) == hash(camera)
    assert pickle.loads(pickle.dumps(camera)) == camera
    assert camera != camera.resized(9, 9) and camera != "camera"
    with pytest.raises(AttributeError):
        camera.width = 3


LENS = {"width": 64, "height": 48, "model": "OPENCV_FISHEYE",
        "parameters": (30, 31, 32, 24, 0.01, 0, 0, -0.002)}


def test_a_camera_has_the_model_and_the_parameters_of_colmap(quadsplat, scene, program, tmp_path):
    view = scene.cameras()[32].view_from_world
    camera = quadsplat.Camera(**LENS, view_from_world=view, name="a")
    assert camera.model == "OPENCV_FISHEYE" and camera.parameters == LENS["parameters"]
    assert pickle.loads(pickle.dumps(camera)) == camera
    assert "64 x 48, OPENCV_FISHEYE, at" in repr(camera)
    half = camera.resized(32, 24)
    assert half.parameters == (15, 15.5, 16, 12, 0.01, 0, 0, -0.002) and half.model == camera.model
    picture = quadsplat.render(scene, camera, outputs=("color", "alpha", "depth"))
    program("render", scene.facts.path, "--camera-index", 32, "--backend", "cpu", "--lens",
            "OPENCV_FISHEYE,64,48,30,31,32,24,0.01,0,0,-0.002", "--size", "64x48", "--output", tmp_path / "a.npy")
    assert np.array_equal(picture.color, np.load(tmp_path / "a.npy"))
    assert picture.depth.max() > 0 and picture.counts.tile_pairs > 0
    parallel = quadsplat.Camera(64, 48, view_from_world=view, model="ORTHOGRAPHIC", parameters=[5])
    assert quadsplat.render(scene, parallel, outputs="pairs").pairs.sum() > 0
    around = quadsplat.Camera(64, 32, view_from_world=view, model="EQUIRECTANGULAR",
                              parameters=(64, 32))
    assert quadsplat.render(scene, around).color.max() > 0


def test_a_model_without_distortion_is_a_pinhole_camera(quadsplat):
    for model, parameters in [("PINHOLE", (50, 51, 20, 15)), ("SIMPLE_PINHOLE", (50, 20, 15)),
                              ("OPENCV", (50, 51, 20, 15, 0, 0, 0, 0))]:
        camera = quadsplat.Camera(40, 30, model=model, parameters=parameters)
        focal = (50, 50 if model == "SIMPLE_PINHOLE" else 51)
        assert camera == quadsplat.Camera(40, 30, focal, (19.5, 14.5)) and camera.model is None


def test_files_give_lenses_if_they_are_wanted(quadsplat):
    path = ROOT / "tests" / "data" / "lenses" / "cameras.json"
    face, = quadsplat.read_cameras(path)
    taken, = quadsplat.read_cameras(path, lenses=True)
    assert face.model is None and face.width == 46
    assert taken.model == "OPENCV_FISHEYE" and taken.width == 64
    assert taken.parameters == (20.4, 20.4, 32, 32, 0.01, 0, 0, 0)
    assert taken.position == pytest.approx([0, 0, 1])


def test_models_that_do_not_fit_are_refused_in_a_sentence(quadsplat, scene):
    for change, sentence in [
            ({"model": "FISH"}, "Camera: model: 'FISH' is no camera model of COLMAP"),
            ({"model": "x" * 40}, "is no camera model"),
            ({"model": 5}, "Camera: model is 5 instead of the name of a camera model"),
            ({"model": None}, "Camera: model is None instead of the name of a camera model"),
            ({"parameters": (30, 31, 32)}, "parameters: OPENCV_FISHEYE has 8 of them, but 3 are"),
            ({"parameters": range(17)}, "parameters: OPENCV_FISHEYE has 8 of them, but 17 are"),
            ({"parameters": None}, "parameters: OPENCV_FISHEYE has 8 of them, but 0 are given"),
            ({"parameters": "abc"}, "Camera: parameters is 'abc' instead of"),
            ({"focal_px": 30}, "OPENCV_FISHEYE has its parameters, so focal_px and center_px"),
            ({"model": "EQUIRECTANGULAR", "parameters": (64, 48)}, "is not twice as wide as high")]:
        with pytest.raises(quadsplat.UsageError) as raised:
            quadsplat.Camera(**{**LENS, **change})
        assert sentence in str(raised.value), change
    with pytest.raises(quadsplat.UsageError, match="^Camera: focal_px is missing"):
        quadsplat.Camera(8, 6)
    camera = quadsplat.Camera(**LENS)
    needs_pinhole = "no pinhole camera|takes a pinhole camera"
    for work in [lambda: camera.focal_px, lambda: camera.center_px, camera.intrinsics,
                 lambda: quadsplat.tile_lists(scene, camera),
                 lambda: quadsplat.counts(scene, camera),
                 lambda: quadsplat.measure(scene, camera, [(1, 1)]),
                 lambda: scene.select(tool="rectangle", camera=camera, pixels=[(0, 0), (9, 9)])]:
        with pytest.raises(quadsplat.UsageError, match=needs_pinhole):
            work()
    with pytest.raises(quadsplat.UsageError, match="so evaluated, pairs and used must be absent"):
        quadsplat.render(scene, camera, outputs="pairs")


def test_impossible_cameras_are_refused_in_a_sentence(quadsplat):
    nan, inf = float("nan"), float("inf")
    usual = {"width": 8, "height": 6, "focal_px": 5}
    mirrored = np.diag([1.0, 1, -1, 1])
    moved = np.eye(4)
    moved[3, 0] = 1
    for change, sentence in [
            ({"width": 0}, "Camera: width: 0 is not between 1 and 65535"),
            ({"width": 2**40}, "Camera: width: 1099511627776 is not between 1 and 65535"),
            ({"height": 2.5}, "Camera: height is 2.5 instead of an integer"),
            ({"focal_px": nan}, "Camera: focal_px: nan and nan are not above 0"),
            ({"focal_px": (1, -1)}, "Camera: focal_px: 1 and -1 are not above 0"),
            ({"focal_px": (1, 2, 3)}, "Camera: focal_px is (1, 2, 3) instead of 2 numbers"),
            ({"focal_px": "wide"}, "Camera: focal_px is 'wide' instead of a number"),
            ({"view_from_world": np.full((4, 4), nan)},
             "Camera: view_from_world has NaN or infinite values"),
            ({"view_from_world": np.full((3, 4), inf)},
             "Camera: view_from_world has NaN or infinite values"),
            ({"view_from_world": np.zeros((3, 4))}, "Camera: view_from_world: its rotation is not"),
            ({"view_from_world": 2 * np.eye(4)[:3]},
             "Camera: view_from_world: its rotation is not"),
            ({"view_from_world": mirrored}, "Camera: view_from_world: its rotation is not"),
            ({"view_from_world": moved}, "it may be transposed"),
            ({"view_from_world": np.eye(3)},
             "Camera: view_from_world has the shape (3, 3) instead of (4, 4) or (3, 4)"),
            ({"view_from_world": "x"}, "Camera: view_from_world has elements of type <U1"),
            ({"near_depth": -1}, "Camera: near_depth: -1 is below 0"),
            ({"near_depth": nan}, "Camera: near_depth: nan is below 0"),
            ({"center_px": (inf, 0)}, "Camera: "),
            ({"center_px": 3}, "Camera: center_px is 3 instead of 2 numbers")]:
        with pytest.raises(quadsplat.UsageError) as raised:
            quadsplat.Camera(**{**usual, **change})
        assert sentence in str(raised.value), change
        assert str(raised.value).startswith("Camera: ")
    for change, sentence in [
            ({"target": (0, 0, 0)}, "Camera.look_at: eye and target are the same point"),
            ({"up": (0, 0, 3)}, "Camera.look_at: up is parallel to the view"),
            ({"up": (0, 0, 0)}, "Camera.look_at: up has length 0"),
            ({"target": (0, nan, 0)}, "Camera.look_at: "),
            ({"fov_y_degrees": 180}, "Camera.look_at: fov_y_degrees: 180 is not between 0 and 180"),
            ({"fov_y_degrees": math.nan}, "Camera.look_at: fov_y_degrees: nan is not")]:
        with pytest.raises(quadsplat.UsageError) as raised:
            quadsplat.Camera.look_at(**{"eye": (0, 0, 0), "target": (0, 0, 1), "width": 8,
                                        "height": 8, **change})
        assert str(raised.value).startswith(sentence), change
    with pytest.raises(quadsplat.UsageError, match="intrinsics is not of the form"):
        quadsplat.Camera.from_intrinsics([[1, 2, 3], [0, 1, 1], [0, 0, 1]], np.eye(4), 8, 8)
    with pytest.raises(quadsplat.InputError, match="^/none: cannot be read"):
        quadsplat.read_cameras("/none")
