# SPDX-License-Identifier: MIT
"""The paper's data sets and the folders in which they are searched. Nothing is downloaded."""
import dataclasses
import math
import pathlib
import re
from typing import Optional

from .pictures import photographs, size_of

Crop = tuple[int, int, int, int, int]  # number among the test views, x, y, width, height
WIDEST = 1600  # pixels; train reduces wider photographs


@dataclasses.dataclass(frozen=True)
class DataSet:
    name: str
    folders: tuple[str, ...]  # below ROOT
    scenes: dict[str, str]    # scene -> folder of its photographs
    source: str               # the place where users get it


SETS = (
    DataSet("Mip-NeRF 360", ("360_v2", "360", "mipnerf360", "."),
            dict.fromkeys(("bicycle", "flowers", "garden", "stump", "treehill"), "images_4") |
            dict.fromkeys(("room", "counter", "kitchen", "bonsai"), "images_2"),
            "https://jonbarron.info/mipnerf360: 360_v2.zip, about 12.5 GB; flowers and treehill are in "
            "360_extra_scenes.zip, about 4.5 GB"),
    DataSet("Tanks and Temples", ("tandt", "tandt_db/tandt"), dict.fromkeys(("truck", "train"), "images"),
            "https://github.com/graphdeco-inria/gaussian-splatting names tandt_db.zip, about 0.65 GB; the licence is "
            "at https://www.tanksandtemples.org"),
    DataSet("Deep Blending", ("db", "tandt_db/db"), dict.fromkeys(("drjohnson", "playroom"), "images"),
            "https://github.com/graphdeco-inria/gaussian-splatting names tandt_db.zip, about 0.65 GB"),
)
OWN = "Own scenes"
CROPS: dict[str, Crop] = {"bicycle": (6, 540, 445, 190, 130), "playroom": (23, 640, 50, 200, 100),
                          "truck": (23, 290, 0, 200, 100)}
ZOOMED = ("counter", "room", "kitchen", "bonsai", "playroom", "drjohnson")  # indoor scenes, the preferred one first


@dataclasses.dataclass
class Scene:
    name: str
    set: str
    data: str            # folder
    images: str          # folder in `data`
    width: int           # pixels of a photograph; 0: unknown
    height: int
    views: int           # photographs
    points: int          # points of the COLMAP model; 0: none
    scale: int           # photographs are reduced to 1/scale
    crop: Optional[Crop] = None

    @property
    def megapixels(self) -> float:
        return self.width * self.height / 1e6 / self.scale ** 2


def has_cameras(folder: pathlib.Path) -> bool:
    return (folder / "sparse").is_dir() or (folder / "transforms.json").is_file() or (folder / "cameras.json").is_file()


def point_count(data: pathlib.Path) -> int:
    """The number of points in a COLMAP model; 0 without one."""
    for folder in (data / "sparse/0", data / "sparse"):
        if (folder / "points3D.bin").is_file():
            with open(folder / "points3D.bin", "rb") as file:
                return int.from_bytes(file.read(8), "little")
        if (folder / "points3D.txt").is_file():
            with open(folder / "points3D.txt", encoding="utf-8") as file:
                return sum(not line.startswith("#") for line in file)
    return 0


def scene_of(name: str, set_name: str, data: pathlib.Path, images: str, scale: Optional[int]) -> Optional[Scene]:
    """None if the folder of the photographs holds none."""
    pictures = photographs(data / images)
    if not pictures:
        return None
    width, height = size_of(pictures[0]) or (0, 0)
    crop = CROPS.get(name) if set_name != OWN else (0, width // 3, height // 3, width // 3, height // 3)
    return Scene(name, set_name, str(data), images, width, height, len(pictures), point_count(data),
                 scale or max(1, math.ceil(width / WIDEST)), crop)


def own_folders(root: pathlib.Path) -> list[pathlib.Path]:
    """Data sets in ROOT, in its folders and in their folders; ROOT itself if it is one."""
    if has_cameras(root) and (root / "images").is_dir():
        return [root]
    nested = [folder for pattern in ("*", "*/*") for folder in sorted(root.glob(pattern)) if folder.is_dir()]
    return [folder for folder in nested if has_cameras(folder) and (folder / "images").is_dir()]


def find_scenes(root: pathlib.Path, scale: Optional[int]) -> tuple[list[Scene], list[tuple[DataSet, str, str]]]:
    """The scenes in ROOT, the paper's first, and (set, scene, reason) for the paper's that are missing."""
    scenes, missing, seen = [], [], set()
    for data_set in SETS:
        for name, images in data_set.scenes.items():
            found = next((root / folder / name for folder in data_set.folders if has_cameras(root / folder / name)), None)
            scene = found and scene_of(name, data_set.name, found, images, scale)
            if found:
                seen.add(found.resolve())
            if scene:
                scenes.append(scene)
            else:
                missing.append((data_set, name, f"{found} has no photographs in {images}" if found else "not found"))
    for folder in own_folders(root):
        if folder.resolve() in seen:
            continue
        name = re.sub(r"[^A-Za-z0-9._-]", "_", folder.resolve().name).lstrip(".") or "scene"
        taken = {scene.name for scene in scenes}
        unique = next(text for text in (name, *(f"{name}_{i}" for i in range(2, 10000))) if text not in taken)
        scene = scene_of(unique, OWN, folder.resolve(), "images", scale)
        if scene:
            scenes.append(scene)
    return scenes, missing
