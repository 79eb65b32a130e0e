# SPDX-License-Identifier: MIT
"""The examples, and the code of docs/python.md."""
import os
import re
import shutil
import subprocess
import sys

import pytest

from conftest import PLUSH, ROOT

try:
    import torch
except ImportError:
    torch = None

needs_torch = pytest.mark.skipif(torch is None, reason="torch is not installed (python3-torch)")

EXAMPLES = sorted((ROOT / "examples" / "python").glob("*.py"))
PAGE = ROOT / "docs" / "python.md"


def run(words, folder):
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "python"),
                   "PYTHONWARNINGS": "ignore::RuntimeWarning"}
    done = subprocess.run([sys.executable, "-B", *map(str, words)], cwd=folder, env=environment,
                          capture_output=True, text=True, timeout=500)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_render_writes_a_picture(tmp_path):
    printed = run([ROOT / "examples/python/render.py", PLUSH, "out.png", "--size", "120x90"], tmp_path)
    assert (tmp_path / "out.png").read_bytes().startswith(b"\x89PNG")
    assert "out.png" in printed


def test_compare_modes_prints_a_line_of_every_mode(quadsplat, tmp_path):
    printed = run([ROOT / "examples/python/compare_modes.py", PLUSH, "--size", "120x90"], tmp_path)
    modes = [mode for mode in quadsplat.modes() if not mode.is_peer and mode.name != "reference"]
    lines = {line.split()[0]: line.split() for line in printed.splitlines()[1:]}
    assert list(lines) == [mode.name for mode in modes]
    for mode in modes:
        if mode.is_lossless:
            assert float(lines[mode.name][-1]) > 60


def test_count_pairs_prints_the_pairs_of_the_cameras(quadsplat, tmp_path):
    printed = run([ROOT / "examples/python/count_pairs.py", PLUSH, "--size", "120x90", "--cameras",
                   "3"], tmp_path)
    lines = [line.split() for line in printed.splitlines()]
    assert lines[0][0] == "mode" and len(lines) == 7
    assert {line[0] for line in lines[1:]} >= {"3dgs", "quadbox", "exact"}


@needs_torch
def test_refine_pose_finds_the_pose(tmp_path):
    printed = run([ROOT / "examples/python/refine_pose.py"], tmp_path)
    before, after = (float(line.split()[1]) for line in printed.splitlines()[-2:])
    assert before > 0.05 and after < 0.002


@needs_torch
def test_train_writes_a_model_of_the_photographs(quadsplat, scene, tmp_path):
    (tmp_path / "images").mkdir()
    for camera in scene.cameras()[::16]:
        quadsplat.render(scene, camera.resized(40, 30)).save(tmp_path / "images" / f"{camera.name}.png")
    printed = run([ROOT / "examples/python/train.py", ROOT / "assets/cameras.json", "images", "out.ply",
                   "--gaussians", "300", "--iterations", "200", "--radius", "2"], tmp_path).splitlines()
    first, last = (float(line.split()[-1]) for line in (printed[0], printed[-2]))
    assert last < 0.6 * first and float(printed[-1].split()[-2]) > 15
    assert len(quadsplat.load(tmp_path / "out.ply")) == 300


def test_every_example_is_tested_and_documented():
    assert [path.stem for path in EXAMPLES] == ["compare_modes", "count_pairs", "refine_pose", "render", "train"]
    for path in EXAMPLES:
        assert f"examples/python/{path.name}" in PAGE.read_text()


@pytest.fixture(scope="module")
def folder(write_data_set, tmp_path_factory):
    made = tmp_path_factory.mktemp("page")
    write_data_set(made / "garden")
    for name in ("plush.ply", "cameras.json", "plush.png"):
        shutil.copy(ROOT / "assets" / name, made)
    return made


def test_the_code_of_the_page_runs(folder):
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.S)
    assert len(blocks) >= 6
    if torch is None:
        blocks = [block for block in blocks if "torch" not in block]
    (folder / "page.py").write_text("\n".join(blocks))
    run(["page.py"], folder)
    assert (folder / "first.png").exists()


def test_the_page_names_everything_public(quadsplat):
    text = PAGE.read_text()
    assert [name for name in quadsplat.__all__ if not re.search(rf"\b{name}\b", text)] == []
