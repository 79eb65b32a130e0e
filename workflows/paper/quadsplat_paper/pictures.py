# SPDX-License-Identifier: MIT
"""The few picture operations of the workflow: sizes of photographs, and crops of PPM files as PNG."""
import pathlib
import struct
import zlib
from typing import Optional

PHOTOGRAPHS = (".png", ".jpg", ".jpeg", ".ppm", ".pfm", ".webp", ".exr", ".tif", ".tiff", ".bmp")
JPEG_SIZES = {0xC0, 0xC1, 0xC2, 0xC3, 0xC5, 0xC6, 0xC7, 0xC9, 0xCA, 0xCB, 0xCD, 0xCE, 0xCF}


def photographs(folder: pathlib.Path) -> list[pathlib.Path]:
    """All pictures of a folder and its subfolders, sorted by name."""
    return sorted(path for path in folder.rglob("*") if path.suffix.lower() in PHOTOGRAPHS and path.is_file())


def size_of(path: pathlib.Path) -> Optional[tuple[int, int]]:
    """(width, height) of a PNG, JPEG or PPM file; None for other formats and damaged files."""
    with open(path, "rb") as file:
        head = file.read(32)
        if head.startswith(b"\x89PNG") and len(head) >= 24:
            return struct.unpack(">II", head[16:24])
        if head.startswith(b"P6"):
            words = head.split(maxsplit=3)
            return (int(words[1]), int(words[2])) if len(words) > 3 else None
        if not head.startswith(b"\xff\xd8"):
            return None
        file.seek(2)
        while True:
            marker = file.read(4)
            if len(marker) < 4 or marker[0] != 0xFF:
                return None
            if marker[1] in JPEG_SIZES:
                found = file.read(5)
                return struct.unpack(">HH", found[1:5])[::-1] if len(found) == 5 else None
            file.seek(struct.unpack(">H", marker[2:4])[0] - 2, 1)


def read_ppm(path: pathlib.Path) -> tuple[int, int, bytes]:
    """(width, height, RGB bytes) of a PPM file as quadsplat writes it: P6, 8 bits."""
    content = path.read_bytes()
    magic, width, height, _ = content.split(maxsplit=3)
    if magic != b"P6":
        raise ValueError(f"{path}: is no PPM of 8 bits")
    rgb = content[-3 * int(width) * int(height):]
    return int(width), int(height), rgb


def crop_ppm(source: pathlib.Path, target: pathlib.Path, part: tuple[int, int, int, int]) -> None:
    """Writes the part (x, y, width, height) as PNG; it is moved and cut to lie inside the picture."""
    width, height, rgb = read_ppm(source)
    w, h = max(1, min(part[2], width)), max(1, min(part[3], height))
    x, y = max(0, min(part[0], width - w)), max(0, min(part[1], height - h))
    rows = (rgb[3 * ((y + i) * width + x):3 * ((y + i) * width + x + w)] for i in range(h))

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", w, h, 8, 2, 0, 0, 0)) +
                       chunk(b"IDAT", zlib.compress(b"".join(b"\0" + row for row in rows))) + chunk(b"IEND", b""))
