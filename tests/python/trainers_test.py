# SPDX-License-Identifier: MIT
"""Trainers of other rasterizers' interfaces reach the quality of `quadsplat train`, with the same settings."""
import json
import os
import subprocess
import sys

import numpy as np
import pytest

from conftest import ROOT

pytest.importorskip("torch", reason="torch is not installed (python3-torch)")

LOOPS = ROOT / "tests" / "python" / "loops"
VIEWS, WIDTH, HEIGHT, FOCAL, POINTS = 20, 64, 48, 60.0, 300
# Gaussians are added after 600 iterations.
BEFORE, AFTER = 590, 690


@pytest.fixture(scope="module")
def folder(quadsplat, tmp_path_factory):
    """Pictures of a coloured ball of Gaussians from a circle, as a COLMAP folder and as .npz."""
    made = tmp_path_factory.mktemp("ball")
    random = np.random.default_rng(4)
    directions = random.normal(0, 1, (POINTS, 3))
    points = directions / np.linalg.norm(directions, axis=1)[:, None] * random.uniform(0.5, 1, (POINTS, 1))
    colors = 0.5 + 0.4 * np.sin(3 * points + [0, 2, 4])
    with quadsplat.Context("cpu") as context:
        ball = quadsplat.Scene.from_arrays(points, random.uniform(0.05, 0.2, (POINTS, 3)),
                                           random.normal(0, 1, (POINTS, 4)),
                                           random.uniform(0.4, 0.95, POINTS), colors=colors, context=context)
        angles = 2 * np.pi * np.arange(VIEWS) / VIEWS
        cameras = [quadsplat.Camera.look_at((4 * np.cos(a), np.sin(3 * a), 4 * np.sin(a)), (0, 0, 0), WIDTH, HEIGHT,
                                            fov_y_degrees=np.degrees(2 * np.arctan(HEIGHT / 2 / FOCAL)))
                   for a in angles]
        images = [quadsplat.render(ball, camera, dtype="uint8").color for camera in cameras]
        (made / "images").mkdir()
        for number, picture in enumerate(quadsplat.render(ball, cameras)):
            picture.save(made / "images" / f"{number:02}.png")
    # Training starts from points that are not quite on the ball.
    start = points + random.normal(0, 0.05, points.shape)
    np.savez(made / "data.npz", images=np.stack(images), views=np.stack([c.view_from_world for c in cameras]),
             focal=cameras[0].focal_px, points=start.astype(np.float32), colors=np.floor(colors * 255) / 255)
    sparse = made / "sparse" / "0"
    sparse.mkdir(parents=True)
    sparse.joinpath("cameras.txt").write_text(
        f"1 PINHOLE {WIDTH} {HEIGHT} {cameras[0].focal_px[0]} {cameras[0].focal_px[1]} {WIDTH / 2} {HEIGHT / 2}\n")
    sparse.joinpath("images.txt").write_text("".join(
        f"{number + 1} {' '.join(map(str, quaternion(camera.view_from_world)))} "
        f"{' '.join(map(str, camera.view_from_world[:3, 3]))} 1 {number:02}.png\n\n"
        for number, camera in enumerate(cameras)))
    sparse.joinpath("points3D.txt").write_text("".join(
        f"{number + 1} {' '.join(repr(float(np.float32(value))) for value in point)} "
        f"{' '.join(str(int(value * 255)) for value in color)} 0.5\n"
        for number, (point, color) in enumerate(zip(start, colors))))
    return made


def quaternion(view):
    """w x y z of a rotation, in its first three rows and columns."""
    values, vectors = np.linalg.eigh(np.array([
        [view[0, 0] - view[1, 1] - view[2, 2], 0, 0, 0],
        [view[1, 0] + view[0, 1], view[1, 1] - view[0, 0] - view[2, 2], 0, 0],
        [view[2, 0] + view[0, 2], view[2, 1] + view[1, 2], view[2, 2] - view[0, 0] - view[1, 1], 0],
        [view[2, 1] - view[1, 2], view[0, 2] - view[2, 0], view[1, 0] - view[0, 1],
         view[0, 0] + view[1, 1] + view[2, 2]]]) / 3)
    x, y, z, w = vectors[:, np.argmax(values)]
    return w, x, y, z


@pytest.fixture(scope="module")
def own(program, folder):
    """PSNR and Gaussians of `quadsplat train` at both iterations."""
    model = folder / "model"
    program("train", folder, "--out-dir", model, "--strategy", "adc", "--iterations", AFTER, "--eval-every", BEFORE, "--sh-degree", 0,
            "--cull", "3dgs", "--count-views", "mode", "--backend", "cpu", "--keep-last")
    rows = json.loads((model / "train.json").read_text())["log"]
    return [{"psnr": row["test_psnr"], "gaussians": row["gaussians"]} for row in rows if "test_psnr" in row]


@pytest.mark.parametrize("loop", ["inria_loop", "gsplat_loop"])
def test_a_trainer_reaches_the_quality_of_the_program(folder, own, loop):
    done = subprocess.run(
        [sys.executable, "-B", "-m", "quadsplat.dropin", "--cull", "3dgs", LOOPS / f"{loop}.py",
         folder / "data.npz", f"{BEFORE},{AFTER}", "0", "0"], capture_output=True, text=True, timeout=800,
        env={**os.environ, "PYTHONPATH": str(ROOT / "python")})
    assert done.returncode == 0, done.stderr
    found = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(found) == len(own) == 2 and own[0]["psnr"] > 35 and own[0]["gaussians"] == POINTS
    assert found[0]["psnr"] == pytest.approx(own[0]["psnr"], abs=0.2)
    assert found[0]["gaussians"] == POINTS and own[1]["gaussians"] > 1.5 * POINTS
    # Places of new Gaussians are random.
    assert found[1]["gaussians"] == pytest.approx(own[1]["gaussians"], rel=0.05)
    assert found[1]["psnr"] == pytest.approx(own[1]["psnr"], abs=1)
