#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Packs the Python package and a built libquadsplat into a wheel: pack_wheel.py LIBRARY FOLDER [--any-linux]

The tag says the oldest glibc that works, from the symbols of the library. It fails if that is above 2.34, if the library
needs libraries that a system may lack and that are not packed with it, or if the wheel has more than 15 MB. --any-linux: for tests, a wheel for this machine
alone (linux_x86_64), of any library. Prints the path of the wheel. scripts/wheel builds the library and calls this.
Needs objdump and strip. Source of the format: PyPA's specifications of binary distributions and of platform tags.
"""
from __future__ import annotations

import argparse
import base64
import hashlib
import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
NEWEST_GLIBC = (2, 34)  # the version of RHEL 9 and Ubuntu 22.04
NEWEST_OF_TAG = {"GLIBCXX": (3, 4, 29), "CXXABI": (1, 3, 13)}  # that systems with this glibc have
OLDEST_GLIBC = (2, 17)  # no older tag exists for it
MOST_BYTES = 15_000_000
# The C library's own parts, and the compiler's libraries, which every system with a C++ program has.
SYSTEM_LIBRARIES = re.compile(r"lib(c|m|dl|rt|pthread|gcc_s|stdc\+\+)\.so|ld-linux")
PACKED_LIBRARIES = ("libhwy.so.1",)  # Debian has no static one
# Debian's packages of the libraries in the wheel.
LICENCES = ("libdeflate-dev libfmt-dev libglm-dev libhwy-dev libjpeg62-turbo-dev libpng-dev libstdc++6 libtinygltf-dev libwebp-dev "
            "libzstd-dev nlohmann-json3-dev zlib1g-dev").split()


def fail(sentence: str) -> None:
    sys.exit(f"pack_wheel.py: {sentence}")


def output(*words: object) -> str:
    return subprocess.run([str(word) for word in words], check=True, capture_output=True, text=True).stdout


def packed_libraries(library: Path) -> list[Path]:
    """The shared libraries that belong into the wheel. Fails if it needs others."""
    places = dict(re.findall(r"(\S+) => (/\S+)", output("ldd", library)))
    packed = []
    for needed in re.findall(r"NEEDED\s+(\S+)", output("objdump", "-p", library)):
        if needed in PACKED_LIBRARIES and needed in places:
            packed.append(Path(places[needed]))
        elif not SYSTEM_LIBRARIES.match(needed) or needed.startswith("libstdc++"):
            fail(f"{library} needs {needed}, which a system may lack: build it with QUADSPLAT_STATIC=ON")
    return packed


def oldest_glibc(library: Path) -> tuple[int, ...]:
    """The glibc whose symbols the library needs."""
    newest = OLDEST_GLIBC
    symbols = re.findall(r"\((GLIBC|GLIBCXX|CXXABI)_([0-9.]+)\)\s+(\S+)", output("objdump", "-T", library))
    for family, text, name in symbols:
        version = tuple(map(int, text.split(".")))
        if version > NEWEST_OF_TAG.get(family, (*NEWEST_GLIBC, 9)):
            fail(f"{library} needs {family}_{text} for {name}, which systems with glibc "
                 f"{NEWEST_GLIBC[0]}.{NEWEST_GLIBC[1]} lack")
        if family == "GLIBC":
            newest = max(newest, version[:2])
    return newest


def stripped(library: Path) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "stripped.so"
        output("strip", "--strip-unneeded", "-o", copy, library)
        return copy.read_bytes()


def metadata(version: str) -> str:
    return f"""Metadata-Version: 2.1
Name: quadsplat
Version: {version}
Summary: Reads, renders, counts, converts and compares scenes of 3D Gaussian Splatting
License: MIT
Requires-Python: >=3.8
Requires-Dist: numpy
Classifier: License :: OSI Approved :: MIT License
Classifier: Operating System :: POSIX :: Linux
Classifier: Programming Language :: Python :: 3
Classifier: Topic :: Multimedia :: Graphics :: 3D Rendering
Classifier: Typing :: Typed
Description-Content-Type: text/markdown

    import quadsplat
    scene = quadsplat.load("plush.ply")
    quadsplat.render(scene, scene.cameras()[0]).save("first.png")

Everything works on the CPU. NVIDIA GPUs are used where the driver supports the CUDA version that `quadsplat.report()` prints.
docs/python.md of the project is the guide.
"""


def record_line(name: str, content: bytes) -> str:
    digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
    return f"{name},sha256={digest},{len(content)}\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("library", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--any-linux", action="store_true")
    options = parser.parse_args()
    if not options.library.is_file():
        fail(f"{options.library} does not exist")

    version = re.search(r"^project\(quadsplat VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text(), re.M).group(1)
    files = {"quadsplat/libquadsplat.so": stripped(options.library)}
    if options.any_linux:
        tag = "py3-none-linux_x86_64"
    else:
        packed = packed_libraries(options.library)
        major, minor = max(oldest_glibc(path) for path in [options.library, *packed])
        tag = f"py3-none-manylinux_{major}_{minor}_x86_64"
        for path in packed:
            needed = re.findall(r"NEEDED\s+(\S+)", output("objdump", "-p", path))
            if not all(map(SYSTEM_LIBRARIES.match, needed)):
                fail(f"{path} needs a library that a system may lack: {', '.join(needed)}")
            files[f"quadsplat/{path.name}"] = stripped(path)
    package = ROOT / "python" / "quadsplat"
    for path in sorted(package.rglob("*")):
        if path.suffix == ".py" or path.name == "py.typed":
            files[f"quadsplat/{path.relative_to(package)}"] = path.read_bytes()
    info = f"quadsplat-{version}.dist-info"
    files[f"{info}/METADATA"] = metadata(version).encode()
    files[f"{info}/WHEEL"] = (f"Wheel-Version: 1.0\nGenerator: quadsplat {version}\nRoot-Is-Purelib: false\n"
                              f"Tag: {tag}\n").encode()
    files[f"{info}/licenses/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    for name in LICENCES:
        copyright_file = Path("/usr/share/doc") / name / "copyright"
        if copyright_file.exists():
            files[f"{info}/licenses/{name}"] = copyright_file.read_bytes()
    record = "".join(record_line(name, content) for name, content in files.items()) + f"{info}/RECORD,,\n"
    files[f"{info}/RECORD"] = record.encode()

    options.folder.mkdir(parents=True, exist_ok=True)
    wheel = options.folder / f"quadsplat-{version}-{tag}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name)  # dated 1980, so that equal files give equal wheels
            entry.external_attr = (0o100755 if ".so" in name else 0o100644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    if wheel.stat().st_size > MOST_BYTES:
        fail(f"{wheel} has {wheel.stat().st_size / 1e6:.1f} MB, more than {MOST_BYTES / 1e6:.0f} MB")
    print(wheel)


if __name__ == "__main__":
    main()
