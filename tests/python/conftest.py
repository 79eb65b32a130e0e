# SPDX-License-Identifier: MIT
"""What the tests share. ctest sets QUADSPLAT (the program), QUADSPLAT_LIBRARY and PYTHONPATH."""
import os
import shutil
import signal
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent.parent
PLUSH = ROOT / "assets" / "plush.ply"
sys.path.insert(0, str(ROOT / "python"))
# A shell ignores Ctrl-C for what it runs in the background, and tests press it.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def quadsplat():
    import quadsplat as package

    return package


@pytest.fixture(scope="session")
def cpu(quadsplat):
    return quadsplat.Context("cpu")


@pytest.fixture(scope="session")
def scene(quadsplat, cpu):
    return quadsplat.load(PLUSH, context=cpu)


@pytest.fixture(scope="session")
def camera(scene):
    return scene.cameras()[32].resized(150, 101)


@pytest.fixture(scope="session")
def program():
    """Runs the program."""
    path = os.environ.get("QUADSPLAT")
    if not path:
        pytest.skip("QUADSPLAT does not name the program")

    def run(*words):
        return subprocess.run([path, *map(str, words)], check=True, capture_output=True, text=True)

    return run


@pytest.fixture(scope="session")
def write_data_set(quadsplat, scene):
    """Writes small photographs of the bundled scene, with their cameras."""

    def write(folder):
        (folder / "images").mkdir(parents=True)
        shutil.copy(ROOT / "assets" / "cameras.json", folder)
        for camera in scene.cameras()[:8]:
            small = camera.resized(camera.width // 16, camera.height // 16)
            quadsplat.render(scene, small).save(folder / "images" / f"{camera.name}.png")

    return write


@pytest.fixture
def python():
    """Runs code in another Python process with the package. Returns what it printed."""

    def run(code, **environment):
        done = subprocess.run(
            [sys.executable, "-B", "-c", code], capture_output=True, text=True, timeout=300,
            env={**os.environ, "PYTHONPATH": str(ROOT / "python"), **environment})
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.fixture
def one(quadsplat, cpu):
    """Makes scenes of one Gaussian in front of the origin; arguments replace its arrays."""

    def make(**changes):
        arrays = {"means": [[0, 0, 2]], "scales": [[0.1, 0.2, 0.3]], "rotations": [[1, 0, 0, 0]],
                  "opacities": [0.8], "colors": [[1, 0.5, 0.25]], "context": cpu, **changes}
        return quadsplat.Scene.from_arrays(**arrays)

    return make


@pytest.fixture(autouse=True)
def no_unexpected_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", "quadsplat draws on the CPU", RuntimeWarning)
        yield
