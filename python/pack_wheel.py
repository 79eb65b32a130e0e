#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Packs the Python package and a built libquadsplat into a wheel: pack_wheel.py LIBRARY FOLDER [--any-linux]

The tag says the oldest glibc that works, from the symbols of the library. It fails if that is above 2.34, if the library
needs libraries that a system may lack, or if the wheel has more than 15 MB. --any-linux: for tests, a wheel for this machine
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
NEWEST_GLIBC = (2, 34)  # of RHEL 9 and Ubuntu 22.04
OLDEST_GLIBC = (2, 17)  # no older tag exists for it
MOST_BYTES = 15_000_000
# The C library's own parts, and libgcc_s, which every system with a C++ program has.
SYSTEM_LIBRARIES = re.compile(r"lib(c|m|dl|rt|pthread|gcc_s)\.so|ld-linux")
# Debian's packages of the libraries in the wheel.
LICENCES = ("libfmt-dev libglm-dev libhwy-dev libjpeg62-turbo-dev libpng-dev libstdc++6 libtinygltf-dev libwebp-dev "
            "libzstd-dev nlohmann-json3-dev zlib1g-dev").split()


def fail(sentence: str) -> None:
    sys.exit(f"pack_wheel.py: {sentence}")


def oldest_glibc(library: Path) -> tuple[int, int]:
    """The glibc whose symbols the library needs. Fails if it needs other libraries."""
    headers = subprocess.run(["objdump", "-p", library], check=True, capture_output=True, text=True).stdout
    for needed in re.findall(r"NEEDED\s+(\S+)", headers):
        if not SYSTEM_LIBRARIES.match(needed):
            fail(f"{library} needs {needed}, which a system may lack: build it with QUADSPLAT_STATIC=ON")
    symbols = subprocess.run(["objdump", "-T", library], check=True, capture_output=True, text=True).stdout
    found = {tuple(map(int, version.split(".")[:2])) for version in re.findall(r"\(GLIBC_([0-9.]+)\)", symbols)}
    newest = max(found | {OLDEST_GLIBC})
    if newest > NEWEST_GLIBC:
        names = re.findall(rf"\(GLIBC_{newest[0]}\.{newest[1]}\)\s+(\S+)", symbols)
        fail(f"{library} needs glibc {newest[0]}.{newest[1]} for {', '.join(names)}, "
             f"newer than {NEWEST_GLIBC[0]}.{NEWEST_GLIBC[1]}")
    return newest


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
    if options.any_linux:
        tag = "py3-none-linux_x86_64"
    else:
        major, minor = oldest_glibc(options.library)
        tag = f"py3-none-manylinux_{major}_{minor}_x86_64"
    with tempfile.TemporaryDirectory() as folder:
        stripped = Path(folder) / "libquadsplat.so"
        subprocess.run(["strip", "--strip-unneeded", "-o", stripped, options.library], check=True)
        files = {"quadsplat/libquadsplat.so": stripped.read_bytes()}
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
            entry = zipfile.ZipInfo(name)  # of 1980, so that equal files give equal wheels
            entry.external_attr = (0o100755 if name.endswith(".so") else 0o100644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    if wheel.stat().st_size > MOST_BYTES:
        fail(f"{wheel} has {wheel.stat().st_size / 1e6:.1f} MB, more than {MOST_BYTES / 1e6:.0f} MB")
    print(wheel)


if __name__ == "__main__":
    main()
