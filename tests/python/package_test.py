# SPDX-License-Identifier: MIT
"""The package as files: syntax, types, documentation, and the wheel."""
import ast
import base64
import hashlib
import inspect
import os
import subprocess
import sys
import typing
import zipfile
from pathlib import Path

import pytest

from conftest import PLUSH, ROOT

SOURCES = sorted((ROOT / "python" / "quadsplat").rglob("*.py"))
EXAMPLES = sorted((ROOT / "examples" / "python").glob("*.py"))


@pytest.mark.parametrize("path", SOURCES + EXAMPLES, ids=lambda path: path.name)
def test_the_syntax_is_that_of_python_3_8(path):
    ast.parse(path.read_text(), feature_version=(3, 8))
    assert path.read_text().startswith("# SPDX-License-Identifier: MIT\n")


def test_imports_are_the_standard_library_and_numpy_and_torch_in_its_rooms():
    known = {"numpy", *getattr(sys, "stdlib_module_names", ())}
    if len(known) == 1:
        pytest.skip("this Python does not list its modules")
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.level == 0:
                names.append(node.module)
            room = path.relative_to(ROOT / "python" / "quadsplat").parts[0]
            allowed = known | {"torch": {"torch"}, "dropin": {"torch", "quadsplat", "gsplat"}}.get(room, set())
            assert {name.split(".")[0] for name in names} <= allowed, path


def public(package):
    """(name, function or class) of the package, with the methods of classes."""
    for name in package.__all__:
        thing = getattr(package, name)
        if inspect.isclass(thing) or inspect.isfunction(thing):
            yield name, thing
        if inspect.isclass(thing):
            for method, function in vars(thing).items():
                if isinstance(function, (classmethod, staticmethod)):
                    function = function.__func__
                if isinstance(function, property):
                    function = function.fget
                if inspect.isfunction(function) and not method.startswith("_"):
                    yield f"{name}.{method}", function


def test_everything_public_is_documented_and_typed(quadsplat):
    named = sorted(name for name in vars(quadsplat) if not name.startswith("_"))
    assert [name for name in named if not inspect.ismodule(getattr(quadsplat, name))] == sorted(
        name for name in quadsplat.__all__ if not name.startswith("_"))
    for name, thing in public(quadsplat):
        if getattr(thing, "__module__", "").startswith("quadsplat"):
            assert inspect.getdoc(thing), name
        if inspect.isfunction(thing) and thing.__module__.startswith("quadsplat"):
            parameters = list(inspect.signature(thing).parameters.values())
            for parameter in parameters:
                assert (parameter.name in ("self", "cls")
                        or parameter.annotation is not parameter.empty), (name, parameter)
            assert inspect.signature(thing).return_annotation is not inspect.Signature.empty, name
            if sys.version_info >= (3, 9):
                typing.get_type_hints(thing)
    assert (ROOT / "python" / "quadsplat" / "py.typed").exists()


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """A wheel of this build's library, for this machine."""
    library = os.environ.get("QUADSPLAT_LIBRARY")
    if not library:
        pytest.skip("QUADSPLAT_LIBRARY does not name the library")
    done = subprocess.run([sys.executable, "-B", ROOT / "python" / "pack_wheel.py", library,
                           tmp_path_factory.mktemp("wheel"), "--any-linux"],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return Path(done.stdout.strip())


def test_a_wheel_is_as_its_specification_says(quadsplat, wheel):
    version = quadsplat.__version__
    assert wheel.name == f"quadsplat-{version}-py3-none-linux_x86_64.whl"
    info = f"quadsplat-{version}.dist-info"
    with zipfile.ZipFile(wheel) as archive:
        assert archive.testzip() is None
        files = {name: archive.read(name) for name in archive.namelist()}
    assert {"quadsplat/__init__.py", "quadsplat/py.typed", "quadsplat/libquadsplat.so",
            f"{info}/METADATA", f"{info}/WHEEL", f"{info}/RECORD",
            f"{info}/licenses/LICENSE"} <= set(files)
    assert not [name for name in files if "__pycache__" in name]
    lines = files[f"{info}/WHEEL"].decode().splitlines()
    assert lines[0] == "Wheel-Version: 1.0" and "Root-Is-Purelib: false" in lines
    assert "Tag: py3-none-linux_x86_64" in lines
    metadata = files[f"{info}/METADATA"].decode()
    assert f"\nName: quadsplat\nVersion: {version}\n" in metadata
    assert "\nRequires-Python: >=3.8\nRequires-Dist: numpy\n" in metadata
    recorded = dict(line.split(",", 1) for line in files[f"{info}/RECORD"].decode().splitlines())
    assert set(recorded) == set(files) and recorded.pop(f"{info}/RECORD") == ","
    for name, line in recorded.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(files[name]).digest()).rstrip(b"=")
        assert line == f"sha256={digest.decode()},{len(files[name])}"


def test_an_unpacked_wheel_draws(wheel, tmp_path):
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path)
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    environment.pop("QUADSPLAT_LIBRARY")
    done = subprocess.run([sys.executable, "-B", "-W", "ignore", "-c", f"""
import quadsplat
assert quadsplat.__file__.startswith({str(tmp_path)!r})
scene = quadsplat.load({str(PLUSH)!r})
quadsplat.render(scene, scene.cameras()[0].resized(40, 30)).save("a.png")
"""], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_pip_installs_a_wheel_and_removes_it(wheel, tmp_path):
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
    if subprocess.run(pip + ["--version"], capture_output=True).returncode != 0:
        pytest.skip("pip is not installed")
    done = subprocess.run(pip + ["install", "--no-index", "--no-deps", "--no-compile", "--target",
                                 tmp_path / "site", wheel], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "site" / "quadsplat" / "libquadsplat.so").exists()
    shown = subprocess.run(pip + ["show", "--files", "quadsplat"], capture_output=True, text=True,
                           env={**os.environ, "PYTHONPATH": str(tmp_path / "site")})
    assert "License: MIT" in shown.stdout and "quadsplat/_ffi.py" in shown.stdout


def test_a_library_that_needs_others_gets_no_tag(tmp_path):
    done = subprocess.run([sys.executable, "-B", ROOT / "python" / "pack_wheel.py",
                           tmp_path / "none.so", tmp_path], capture_output=True, text=True)
    assert done.returncode == 1 and "none.so does not exist" in done.stderr
    library = os.environ.get("QUADSPLAT_LIBRARY")
    if library is None or "libstdc++" not in subprocess.run(
            ["objdump", "-p", library], capture_output=True, text=True).stdout:
        pytest.skip("the library is linked statically")
    done = subprocess.run([sys.executable, "-B", ROOT / "python" / "pack_wheel.py", library,
                           tmp_path], capture_output=True, text=True)
    assert done.returncode == 1 and "which a system may lack" in done.stderr
    assert not list(tmp_path.iterdir())
