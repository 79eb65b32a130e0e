# SPDX-License-Identifier: MIT
"""Data sets of a lens: scripts/synthetic_set --lens, and the table of scripts/lens_results."""
import json
import os
import subprocess
import sys

import pytest

from conftest import PLUSH, ROOT


@pytest.fixture(scope="module")
def cameras(tmp_path_factory):
    """Three cameras of the bundled scene."""
    path = tmp_path_factory.mktemp("lens_sets") / "cameras.json"
    listed = json.loads((ROOT / "assets" / "cameras.json").read_text())
    path.write_text(json.dumps(listed[:60:20]))
    return path


def run(script, *words):
    program = os.environ.get("QUADSPLAT")
    if not program:
        pytest.skip("QUADSPLAT does not name the program")
    return subprocess.run([sys.executable, ROOT / "scripts" / script, *map(str, words)], capture_output=True,
                          text=True, env={**os.environ, "PROGRAM": program})


@pytest.mark.parametrize("lens", ["OPENCV_FISHEYE,60,45,30,30,30,22.5,0.02,-0.005,0.001,0",
                                  "SIMPLE_RADIAL,60,45,60,30,22.5,-0.1", "EQUIRECTANGULAR,96,48"])
def test_pictures_of_a_lens_are_what_the_lens_shows(program, cameras, tmp_path, lens):
    out = tmp_path / "set"
    made = run("synthetic_set", PLUSH, out, "--cameras", cameras, "--points", 50, "--lens", lens)
    assert made.returncode == 0, made.stderr
    assert (out / "points3D.ply").exists() and not (out / "transforms.json").exists()
    report = program("eval", PLUSH, "--cameras", out, "--images", out / "images", "--lens-eval",
                     "--cull", "quadbox", "--backend", "cpu", "--json", "-")
    mean = json.loads(report.stdout)["means"][0]
    # Pictures of 8 bits have an error of 1 / 255 / sqrt(12), which is 58.9 dB.
    assert mean["photographs"] == 3 and 58 < mean["lens_psnr"] < 63
    assert mean["lens_shown"] == 1


def test_wrong_lenses_are_refused(cameras, tmp_path):
    for words in (["--lens", "fisheye"], ["--lens", "FISHEYE,8,8,4,4,4,4", "--size", "8x8"]):
        made = run("synthetic_set", PLUSH, tmp_path / "none", "--cameras", cameras, *words)
        assert made.returncode == 1 and made.stderr.startswith("synthetic_set: --lens: '")


def test_the_table_has_a_row_per_set(cameras, tmp_path):
    made = run("lens_results", tmp_path / "out", "--cameras", cameras, "--size", "24x18", "--iterations", 2,
               "--points", 300, "--seeds", "0,1", "--backend", "cpu")
    assert made.returncode == 0, made.stderr
    rows = [line.split("|")[1:-1] for line in made.stdout.splitlines()]
    assert [row[0].split(",")[0].strip() for row in rows[2:]] == [
        "pinhole", "pinhole pictures that are drawn by faces", "fisheye of 80 degrees", "fisheye of 130 degrees"]
    for row in rows[2:]:
        for cell in row[1:]:
            mean, low, high = [float(word) for word in cell.replace("(", "").replace(")", "").replace("to", "").split()]
            assert low <= mean <= high
