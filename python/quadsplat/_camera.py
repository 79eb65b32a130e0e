# SPDX-License-Identifier: MIT
"""Cameras."""
from __future__ import annotations

import ctypes
import math
from os import PathLike
from typing import Any, List, Optional, Sequence, Tuple, Union

import numpy as np

from . import _ffi
from ._arrays import real_array
from ._checks import encoded_path, integer, real, reals
from ._errors import UsageError

_MOST_PIXELS = 65535


class Camera:
    """A pinhole camera, or a camera of another model. It does not change: methods return other cameras.

    Axes of the world and of the view are x right, y down, z forward, as in INRIA's .ply files and
    COLMAP. Pixel i has its centre at coordinate i.

    width, height: pixels, 1..65535.
    focal_px: focal length in pixels, one number or (x, y), > 0; None with a model.
    center_px: principal point (x, y) in pixels; None: the middle, ((width - 1) / 2,
        (height - 1) / 2). Software that puts the centre of pixel i at i + 0.5, such as COLMAP and
        gsplat, has a principal point that is larger by 0.5: see from_intrinsics().
    view_from_world: 4 x 4 or 3 x 4, world to camera, a rotation and a translation; None: identity.
    near_depth: Gaussians with view z <= near_depth are not drawn, units of the scene, >= 0.
    name: of the photograph.
    model: None: a pinhole camera; or the name of a camera model of COLMAP, as "OPENCV_FISHEYE", of
        "BROWN_CONRADY", "METASHAPE", "METASHAPE_FISHEYE" and "FISHEYE624", or "ORTHOGRAPHIC",
        for parallel rays. A model without distortion gives a pinhole camera. render() draws all
        models, and everything else takes pinhole cameras alone.
    parameters: numbers of the model, in the order and the units of COLMAP, which puts the centre of
        pixel i at i + 0.5. "EQUIRECTANGULAR" has (width, height), and "ORTHOGRAPHIC" the height of
        the picture in units of the scene.

    Raises UsageError for NaN, infinite or impossible values.
    """

    __slots__ = ("_struct", "_name")

    def __init__(self, width: int, height: int,
                 focal_px: Union[None, float, Sequence[float]] = None,
                 center_px: Optional[Sequence[float]] = None, view_from_world: Any = None,
                 near_depth: float = 0.2, name: str = "", model: Optional[str] = None,
                 parameters: Optional[Sequence[float]] = None) -> None:
        self._name = str(name)
        struct = self._struct = _ffi.QsCamera()
        struct.width = integer(width, "Camera: width", 1, _MOST_PIXELS)
        struct.height = integer(height, "Camera: height", 1, _MOST_PIXELS)
        if model is None and parameters is None:
            _set_pinhole(struct, focal_px, center_px)
        else:
            _set_model(struct, focal_px, center_px, model, parameters)
        matrix = np.eye(4) if view_from_world is None else view_from_world
        struct.view_from_world[:] = _rigid(matrix).reshape(12)
        struct.near_depth = real(near_depth, "Camera: near_depth")
        self._struct = _checked(struct)

    @classmethod
    def from_intrinsics(cls, intrinsics: Any, view_from_world: Any, width: int, height: int, *,
                        pixel_center: float = 0.5, near_depth: float = 0.2,
                        name: str = "") -> Camera:
        """A camera from matrices as COLMAP, OpenCV and gsplat have them.

        intrinsics: 3 x 3, (fx 0 cx; 0 fy cy; 0 0 1), pixels.
        view_from_world: 4 x 4 or 3 x 4, world to camera.
        pixel_center: coordinate of the centre of pixel 0 in (cx, cy): 0.5 for COLMAP and gsplat,
            0 for OpenCV.
        """
        matrix = real_array(intrinsics, "Camera.from_intrinsics: intrinsics", (3, 3))
        if matrix[0, 1] != 0 or matrix[1, 0] != 0 or list(matrix[2]) != [0, 0, 1]:
            raise UsageError("Camera.from_intrinsics: intrinsics is not of the form "
                             "(fx 0 cx; 0 fy cy; 0 0 1)")
        half = real(pixel_center, "Camera.from_intrinsics: pixel_center")
        return cls(width, height, (matrix[0, 0], matrix[1, 1]),
                   (matrix[0, 2] - half, matrix[1, 2] - half), view_from_world, near_depth, name)

    @classmethod
    def look_at(cls, eye: Sequence[float], target: Sequence[float], width: int, height: int, *,
                fov_y_degrees: float = 50.0, up: Sequence[float] = (0.0, -1.0, 0.0),
                near_depth: float = 0.2, name: str = "") -> Camera:
        """A camera at `eye` that has `target` in the middle of its picture.

        eye, target: points of the world.
        fov_y_degrees: vertical field of view, above 0 and below 180.
        up: direction of the world that is upwards in the picture, of any length; usually -y.
        """
        who = "Camera.look_at"
        start = np.array(reals(eye, f"{who}: eye", 3))
        forward = _unit(np.array(reals(target, f"{who}: target", 3)) - start,
                        f"{who}: eye and target are the same point")
        above = _unit(np.array(reals(up, f"{who}: up", 3)), f"{who}: up has length 0")
        right = _unit(np.cross(-above, forward), f"{who}: up is parallel to the view")
        rotation = np.stack([right, np.cross(forward, right), forward])
        fov = real(fov_y_degrees, f"{who}: fov_y_degrees")
        if not 0 < fov < 180:
            raise UsageError(f"{who}: fov_y_degrees: {fov:g} is not between 0 and 180")
        rows = integer(height, f"{who}: height", 1, _MOST_PIXELS)
        return cls(width, rows, rows / 2 / math.tan(math.radians(fov) / 2), None,
                   np.column_stack([rotation, -rotation @ start]), near_depth, name)

    @property
    def width(self) -> int:
        """Pixels."""
        return int(self._struct.width)

    @property
    def height(self) -> int:
        """Pixels."""
        return int(self._struct.height)

    @property
    def model(self) -> Optional[str]:
        """The name of the model; None: a pinhole camera."""
        return _ffi.text(self._struct.model) or None

    @property
    def parameters(self) -> Tuple[float, ...]:
        """The numbers of the model in the order of COLMAP; none of a pinhole camera."""
        return tuple(self._struct.parameters[:self._struct.parameter_count])

    @property
    def focal_px(self) -> Tuple[float, float]:
        """Focal length (x, y), pixels. Raises UsageError with a model, as the next two do."""
        self._require_pinhole()
        return (self._struct.focal_px[0], self._struct.focal_px[1])

    @property
    def center_px(self) -> Tuple[float, float]:
        """Principal point (x, y), pixels; pixel i has its centre at i."""
        self._require_pinhole()
        return (self._struct.center_px[0], self._struct.center_px[1])

    @property
    def view_from_world(self) -> np.ndarray:
        """World to camera, 4 x 4, float64."""
        matrix = np.eye(4)
        matrix[:3] = np.array(self._struct.view_from_world).reshape(3, 4)
        return matrix

    @property
    def position(self) -> np.ndarray:
        """The eye, a point of the world, float64."""
        matrix = self.view_from_world
        return -matrix[:3, :3].T @ matrix[:3, 3]

    @property
    def near_depth(self) -> float:
        """Gaussians with view z <= near_depth are not drawn."""
        return float(self._struct.near_depth)

    @property
    def name(self) -> str:
        """Of the photograph, or empty."""
        return self._name

    def intrinsics(self, pixel_center: float = 0.5) -> np.ndarray:
        """The 3 x 3 matrix of from_intrinsics(), float64."""
        (fx, fy), (cx, cy) = self.focal_px, self.center_px
        return np.array([[fx, 0, cx + pixel_center], [0, fy, cy + pixel_center], [0, 0, 1]])

    def resized(self, width: int, height: int) -> Camera:
        """The camera with another size in pixels. The vertical field of view stays."""
        struct = _copy(self._struct)
        _ffi.call("Camera.resized", "qs_camera_resize", ctypes.byref(struct),
                  integer(width, "Camera.resized: width", 1, _MOST_PIXELS),
                  integer(height, "Camera.resized: height", 1, _MOST_PIXELS))
        return _camera(struct, self._name)

    def _require_pinhole(self) -> None:
        if self.model:
            raise UsageError(f"Camera: the model {self.model} has parameters and is no pinhole "
                             "camera, which is needed here")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Camera):
            return NotImplemented
        return bytes(self._struct) == bytes(other._struct) and self._name == other._name

    def __hash__(self) -> int:
        return hash((bytes(self._struct), self._name))

    def __reduce__(self) -> Any:
        lens = (None, None) if self.model else (self.focal_px, self.center_px)
        return (Camera, (self.width, self.height, *lens, self.view_from_world, self.near_depth,
                         self.name, self.model, self.parameters or None))

    def __repr__(self) -> str:
        name = f" {self._name!r}" if self._name else ""
        x, y, z = self.position
        lens = self.model or f"focal length {self.focal_px[0]:g} px"
        return (f"<quadsplat.Camera{name}: {self.width} x {self.height}, {lens}, at ({x:g}, {y:g}, {z:g})>")


def read_cameras(path: Union[str, PathLike[str]], lenses: bool = False) -> List[Camera]:
    """The cameras of a cameras.json, a transforms.json, or a folder or file of COLMAP.

    lenses: False: a lens that distorts gives the pinhole camera of its undistorted photograph, and
        a lens too wide for one gives a camera of 96 degrees that looks ahead. True: it gives the
        camera that took the photograph, with its model and parameters.

    Raises InputError if the file is missing or damaged.
    """
    handle, count = ctypes.c_void_p(), ctypes.c_uint64()
    _ffi.call("read_cameras", "qs_cameras_open", encoded_path(path, "read_cameras: path"),
              ctypes.byref(handle), ctypes.byref(count))
    try:
        cameras = []
        for number in range(count.value):
            struct, name = _ffi.QsCamera(), ctypes.c_char_p()
            _ffi.call("read_cameras", "qs_cameras_lens" if lenses else "qs_cameras_get", handle, number, ctypes.byref(struct),
                      ctypes.byref(name))
            cameras.append(_camera(struct, _ffi.text(name.value)))
        return cameras
    finally:
        _ffi.library.qs_cameras_close(handle)


def _camera(struct: _ffi.QsCamera, name: str) -> Camera:
    camera = Camera.__new__(Camera)
    camera._struct = struct
    camera._name = name
    return camera


def _copy(struct: _ffi.QsCamera) -> _ffi.QsCamera:
    return _ffi.QsCamera.from_buffer_copy(struct)


def _checked(struct: _ffi.QsCamera) -> _ffi.QsCamera:
    """The camera as the library has it: a model without distortion is a pinhole camera."""
    result = _copy(struct)
    _ffi.call("Camera", "qs_camera_resize", ctypes.byref(result), struct.width, struct.height)
    return result if struct.model else struct


def _set_pinhole(struct: _ffi.QsCamera, focal_px: Any, center_px: Any) -> None:
    if focal_px is None:
        raise UsageError("Camera: focal_px is missing")
    if np.ndim(focal_px) == 0:
        focal_px = (focal_px, focal_px)
    struct.focal_px[:] = reals(focal_px, "Camera: focal_px", 2)
    if center_px is None:
        center_px = ((struct.width - 1) / 2, (struct.height - 1) / 2)
    struct.center_px[:] = reals(center_px, "Camera: center_px", 2)


def _set_model(struct: _ffi.QsCamera, focal_px: Any, center_px: Any, model: Any,
               parameters: Any) -> None:
    if not isinstance(model, str) or not model:
        raise UsageError(f"Camera: model is {model!r} instead of the name of a camera model")
    if focal_px is not None or center_px is not None:
        raise UsageError(f"Camera: {model} has its parameters, so focal_px and center_px must be "
                         "None")
    if len(model.encode()) >= _ffi.QsCamera.model.size:
        raise UsageError(f"Camera: model: {model!r} is no camera model")
    struct.model = model.encode()
    given = () if parameters is None else parameters
    values = reals(given, "Camera: parameters", int(np.size(given)))
    struct.parameter_count = len(values)  # the library refuses more than the model has
    for index, value in enumerate(values[:len(struct.parameters)]):
        struct.parameters[index] = value


def _rigid(matrix: Any) -> np.ndarray:
    """The 3 x 4 part of a matrix. The library checks its rotation."""
    where = "Camera: view_from_world"
    values = real_array(matrix, where).astype(np.float64)
    if values.shape not in ((4, 4), (3, 4)):
        raise UsageError(f"{where} has the shape {values.shape} instead of (4, 4) or (3, 4)")
    if not np.isfinite(values).all():
        raise UsageError(f"{where} has NaN or infinite values")
    if values.shape == (4, 4) and list(values[3]) != [0, 0, 0, 1]:
        raise UsageError(f"{where} has the last row {list(values[3])} instead of 0, 0, 0, 1: it "
                         "may be transposed")
    return np.ascontiguousarray(values[:3])


def _unit(vector: np.ndarray, problem: str) -> np.ndarray:
    largest = np.abs(vector).max()
    if not np.isfinite(largest):
        raise UsageError(problem.split(":")[0] + ": a value is NaN or infinite")
    if largest == 0:
        raise UsageError(problem)
    scaled = vector / largest
    length = np.linalg.norm(scaled)
    return scaled / length
