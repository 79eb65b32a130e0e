# SPDX-License-Identifier: MIT
"""Small data sets for odd_data_sets: reads a COLMAP data set, and writes parts of it in four formats, with changes.

`Data` writes a right data set of kind C (COLMAP binary), T (COLMAP text), J (transforms.json) or I (cameras.json of INRIA) into a
folder `DATA`, and its methods change it. The module also makes masks, PNG pictures, points as .ply and EXIF segments by bytes.
To add a format: a method store_FORMAT, named in Data.store.
"""
import copy
import functools
import json
import math
import shutil
import struct
import zlib

CAMERAS = 12
POINT_STEP = 32  # every 32nd point of the model
MODELS = {"SIMPLE_PINHOLE": 0, "PINHOLE": 1, "SIMPLE_RADIAL": 2, "RADIAL": 3, "OPENCV": 4, "OPENCV_FISHEYE": 5, "FULL_OPENCV": 6, "FOV": 7,
          "SIMPLE_RADIAL_FISHEYE": 8, "RADIAL_FISHEYE": 9, "THIN_PRISM_FISHEYE": 10, "RAD_TAN_THIN_PRISM_FISHEYE": 11,
          "SIMPLE_DIVISION": 12, "DIVISION": 13, "SIMPLE_FISHEYE": 14, "FISHEYE": 15, "EUCM": 16, "EQUIRECTANGULAR": 17}


def read_base(data):
    """Frames (name, quaternion, translation), the lens (w, h, fx, fy, cx, cy) and points (x, y, z, r, g, b) of a COLMAP model."""
    model = data / "sparse/0"
    width, height, *lens = struct.unpack_from("<QQdddd", (model / "cameras.bin").read_bytes(), 16)
    content = (model / "images.bin").read_bytes()
    at, frames = 8, []
    for _ in range(struct.unpack_from("<Q", content)[0]):
        pose = struct.unpack_from("<7d", content, at + 4)
        end = content.index(b"\0", at + 64)
        frames.append([content[at + 64:end].decode(), list(pose[:4]), list(pose[4:])])
        at = end + 9 + 24 * struct.unpack_from("<Q", content, end + 1)[0]
    content, at, points = (model / "points3D.bin").read_bytes(), 8, []
    for _ in range(struct.unpack_from("<Q", content)[0]):
        points.append(list(struct.unpack_from("<dddBBB", content, at + 8)))
        at += 51 + 8 * struct.unpack_from("<Q", content, at + 43)[0]
    frames.sort()
    return frames[::len(frames) // CAMERAS][:CAMERAS], [width, height, *lens], points[::POINT_STEP]


def rotation(q):
    """Rows of the matrix of a quaternion w, x, y, z."""
    w, x, y, z = (v / math.sqrt(sum(u * u for u in q)) for v in q)
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]


@functools.lru_cache
def png(width, height, value, channels=3, bits=8):
    """A PNG picture; value(x, y) gives the samples of a pixel, 0..1."""
    code = {8: "B", 16: ">H"}[bits]
    rows = b"".join(b"\0" + b"".join(struct.pack(code, round(v * (2 ** bits - 1))) for x in range(width) for v in value(x, y)[:channels])
                    for y in range(height))
    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
    header = struct.pack(">IIBBBBB", width, height, bits, {1: 0, 2: 4, 3: 2, 4: 6}[channels], 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b"")


def turned(jpeg, orientation):
    """The JPEG with an EXIF segment behind its first marker."""
    exif = b"Exif\0\0II*\0" + struct.pack("<IHHHIII", 8, 1, 0x112, 3, 1, orientation, 0)
    return jpeg[:2] + b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif + jpeg[2:]


def ply(points, floats=False, colors=True, names=("red", "green", "blue"), header_count=None):
    kind = "float" if floats else "uchar"
    lines = ["ply", "format ascii 1.0", f"element vertex {len(points) if header_count is None else header_count}"]
    lines += [f"property float {axis}" for axis in "xyz"] + [f"property {kind} {name}" for name in names if colors] + ["end_header"]
    for x, y, z, *color in points:
        lines.append(" ".join(map(str, [x, y, z] + ([c / 255 for c in color] if floats else color) * colors)))
    return "\n".join(lines) + "\n"


def blob(x, y):
    """A picture without a photograph: gray in stripes."""
    return ((x // 50 % 2) * 0.5 + 0.25,) * 3 + (1.0 if y < 300 else 0.5,)


def hole(x, y):
    """A mask that is black in a block."""
    return (0.0 if 200 <= x < 500 and 200 <= y < 400 else 1.0,) * 3


class Data:
    """A data set under construction. Methods return the data set, so that changes are chains."""

    def __init__(self, root, base, kind):
        self.root, self.kind, self.target, self.options = root, kind, "DATA", []
        self.source, frames, lens, points = base
        self.frames, self.size, self.lens, self.points = copy.deepcopy(frames), lens[:2], list(lens[2:]), copy.deepcopy(points)
        self.model, self.at, self.places, self.keys, self.prefix = "PINHOLE", "sparse/0", ("points",), {}, "images/"
        for name, *_ in frames:
            self.write(f"images/{name}", (self.source / "images" / name).read_bytes())
        self.names = [frame[0] for frame in frames]
        self.store()

    def path(self, name):
        return self.root / "DATA" / name

    def write(self, name, content):
        path = self.path(name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return self

    def move(self, a, b):
        self.path(b).parent.mkdir(parents=True, exist_ok=True)
        self.path(a).rename(self.path(b))
        return self

    def copy(self, a, b):
        self.path(b).parent.mkdir(parents=True, exist_ok=True)
        (shutil.copytree if self.path(a).is_dir() else shutil.copy)(self.path(a), self.path(b))
        return self

    def remove(self, *names):
        for name in names:
            shutil.rmtree(self.path(name)) if self.path(name).is_dir() else self.path(name).unlink()
        return self

    def link(self, name, to):
        self.path(name).parent.mkdir(parents=True, exist_ok=True)
        self.path(name).symlink_to(to)
        return self

    def photo(self, i, change):
        """Changes the bytes of a photograph."""
        return self.write(f"images/{self.names[i]}", change(self.path(f"images/{self.names[i]}").read_bytes()))

    def photos(self, change):
        """Renames all photographs: change(name, i) is a path in the data set."""
        for i, name in enumerate(self.names):
            self.move(f"images/{name}", change(name, i))
        return self

    def named(self, change):
        """Renames the photographs in the cameras file: change(name, i)."""
        for i, frame in enumerate(self.frames):
            frame[0] = change(frame[0], i)
        return self.store()

    def renamed(self, change):
        """Renames them in both places."""
        return self.photos(lambda n, i: "images/" + change(n, i)).named(change)

    def poses(self, change):
        """change(quaternion, place of the camera, i) gives both again; the translation follows."""
        for i, frame in enumerate(self.frames):
            turn = rotation(frame[1])
            place = [-sum(turn[k][a] * frame[2][k] for k in range(3)) for a in range(3)]
            frame[1], place = change(frame[1], place, i)
            turn = rotation(frame[1])
            frame[2] = [-sum(turn[k][a] * place[a] for a in range(3)) for k in range(3)]
        return self.store()

    def with_lens(self, model, parameters):
        self.model, self.lens = model, parameters
        return self.store()

    def text(self, name, change):
        return self.write(name, change(self.path(name).read_text()))

    def json(self, change, file=None):
        file = file or {"J": "transforms.json", "I": "cameras.json"}[self.kind]
        content = json.loads(self.path(file).read_text())
        change(content)
        return self.write(file, json.dumps(content, indent=1))

    def put(self, **keys):
        """Sets keys of the file."""
        return self.json(lambda file: file.update(keys))

    def frame(self, i, **keys):
        """Sets keys of frame i, or of all."""
        def change(file):
            frames = file if self.kind == "I" else file["frames"]
            for frame in frames if i is None else [frames[i]]:
                frame.update(keys)
        return self.json(change)

    def matrix(self, change, only=None):
        """Changes the matrix of each frame, or of one."""
        def all_of(file):
            for i, frame in enumerate(file["frames"]):
                if only in (None, i):
                    frame["transform_matrix"] = change(frame["transform_matrix"])
        return self.json(all_of)

    def at_place(self, place):
        """Writes the COLMAP model to another folder."""
        shutil.rmtree(self.path(self.at.split("/")[0]))
        self.at = place
        return self.store()

    def given(self, *options, target=None):
        self.options += options
        self.target = target or self.target
        return self

    def store(self):
        {"C": self.store_binary, "T": self.store_text, "J": self.store_transforms, "I": self.store_cameras}[self.kind]()
        return self

    def store_binary(self):
        number = self.model if isinstance(self.model, int) else MODELS[self.model]
        lens = struct.pack("<QIiQQ", 1, 1, number, *self.size) + struct.pack(f"<{len(self.lens)}d", *self.lens)
        images = struct.pack("<Q", len(self.frames))
        for i, (name, q, t) in enumerate(self.frames):
            images += struct.pack("<I7dI", i + 1, *q, *t, 1) + name.encode() + b"\0" + struct.pack("<Q", 0)
        points = struct.pack("<Q", len(self.points))
        for i, point in enumerate(self.points):
            points += struct.pack("<QdddBBBdQ", i + 1, *point, 0.5, 0)
        self.write(f"{self.at}/cameras.bin", lens).write(f"{self.at}/images.bin", images).write(f"{self.at}/points3D.bin", points)

    def store_text(self):
        self.write(f"{self.at}/cameras.txt", f"# Cameras\n1 {self.model} " + " ".join(map(str, [*self.size, *self.lens])) + "\n")
        lines = [" ".join(map(str, [i + 1, *q, *t, 1, name])) + "\n\n" for i, (name, q, t) in enumerate(self.frames)]
        self.write(f"{self.at}/images.txt", "# Images\n" + "".join(lines))
        points = [" ".join(map(str, [i + 1, *point, 0.5])) + "\n" for i, point in enumerate(self.points)]
        self.write(f"{self.at}/points3D.txt", "# Points\n" + "".join(points))

    def store_transforms(self):
        fx, fy, cx, cy = self.lens
        file = {"w": self.size[0], "h": self.size[1], "fl_x": fx, "fl_y": fy, "cx": cx, "cy": cy, "ply_file_path": "points.ply", "frames": []}
        for name, q, t in self.frames:
            turn = rotation(q)
            rows = [[turn[0][a], -turn[1][a], -turn[2][a], -sum(turn[k][a] * t[k] for k in range(3))] for a in range(3)]
            file["frames"].append({"file_path": self.prefix + name, "transform_matrix": [*rows, [0, 0, 0, 1]]})
        self.write("transforms.json", json.dumps(file, indent=1)).write("points.ply", ply(self.points))

    def store_cameras(self):
        cameras = []
        for i, (name, q, t) in enumerate(self.frames):
            turn = rotation(q)
            cameras.append({"id": i, "img_name": name.removesuffix(".jpg"), "width": self.size[0], "height": self.size[1],
                            "position": [-sum(turn[k][a] * t[k] for k in range(3)) for a in range(3)],
                            "rotation": [[turn[k][a] for k in range(3)] for a in range(3)], "fx": self.lens[0], "fy": self.lens[1]})
        self.write("cameras.json", json.dumps(cameras, indent=1)).write("points3D.ply", ply(self.points))


def submodel(d, place, frames):
    """Writes a second COLMAP model with some of the frames."""
    rest, at, d.frames, d.at = d.frames, d.at, frames, place
    d.store()
    d.frames, d.at = rest, at
    return d


def turned_camera(d):
    """The cameras of pictures that were turned by 90 degrees."""
    fx, fy, cx, cy = d.lens
    d.size, d.lens = d.size[::-1], [fy, fx, cy, cx]
    half = math.sqrt(0.5)
    for frame in d.frames:
        (w, x, y, z), t = frame[1:]
        frame[1:] = [half * (w - z), half * (x - y), half * (y + x), half * (z + w)], [-t[1], t[0], t[2]]
    return d.store()


def scaled(factor, aspect=1):
    """Intrinsics of a picture of another size."""
    def change(d):
        d.size = [round(d.size[0] * factor), round(d.size[1] * factor * aspect)]
        d.lens = [v * factor for v in d.lens]
        return d.store()
    return change


def blender(d, files):
    """Blender's files: train has the first 9 frames, test the others, without sizes."""
    frames = json.loads(d.path("transforms.json").read_text())["frames"]
    for i, frame in enumerate(frames):
        frame["file_path"] = "./" + ("train" if i < 9 else "test") + f"/r_{i}"
        d.move(f"images/{d.names[i]}", frame["file_path"] + ".jpg")
    for file in files:
        part = frames[:9] if file != "test" else frames[9:]
        d.write(f"transforms_{file}.json", json.dumps({"camera_angle_x": 1.086, "frames": part}))
    return d.remove("transforms.json", "images")
