# SPDX-License-Identifier: MIT
"""Scenes of 3D Gaussians."""
from __future__ import annotations

import ctypes
import os
import weakref
from os import PathLike
from types import TracebackType
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Tuple, Type, Union

import numpy as np

from . import _ffi
from ._arrays import element_type, real_array, require_shape, struct_of, to_numpy
from ._camera import Camera, read_cameras
from ._checks import encoded, encoded_path, integer
from ._context import Context, chosen
from ._errors import InputError, UsageError
from ._gpu_arrays import is_on_gpu, real_gpu_array
from ._warn import warn

Path = Union[str, "PathLike[str]"]
_ALL_SH_DEGREES = 3
_REALS = ("float32", "float64")


class SceneFacts(NamedTuple):
    """The facts of a scene. Texts are empty where nothing is known."""

    gaussians: int
    not_drawn: int  #: Gaussians that are not drawn, for NaN, infinite or impossible values
    sh_degree: int  #: degree of the colours, 0..3
    low: Tuple[float, float, float]  #: box of the centres, world; 0 without Gaussians
    high: Tuple[float, float, float]
    antialiased: bool  #: trained with opacity compensation
    white_background: bool  #: the model's cfg_args ask for a white background
    path: str  #: the file that was read
    format: str  #: "ply, binary little endian"
    file_bytes: int  #: size of all files that were read
    axes: str  #: the file's axes; the scene's are always RDF: x right, y down, z forward
    vertical_axis: str  #: the axis that the file declares: "y", "-z", ...
    cameras_path: str  #: the file of cameras beside the scene
    warnings: Tuple[str, ...]  #: sentences about the file


class Edited(NamedTuple):
    """A scene after edits: True or False for each Gaussian."""

    selected: np.ndarray  #: N, bool: selected at the end
    left: np.ndarray  #: N, bool: neither hidden nor removed


class Scene:
    """3D Gaussians in a context. load() and Scene.from_arrays() make scenes.

    len() is the number of Gaussians. A scene may be used as a `with` block, which closes it.
    """

    _context: Context
    _scene: ctypes.c_void_p
    _facts: SceneFacts
    _finalizer: Any

    def __init__(self, *_: Any) -> None:
        raise UsageError("Scene: use quadsplat.load() or quadsplat.Scene.from_arrays()")

    @classmethod
    def from_arrays(cls, means: Any, scales: Any, rotations: Any, opacities: Any, sh: Any = None,
                    *, sh_rest: Any = None, colors: Any = None, activated: bool = True,
                    antialiased: bool = False, context: Optional[Context] = None) -> Scene:
        """A scene from N Gaussians, 0 or more. The values are copied.

        means: N x 3, world.
        scales: N x 3, standard deviations >= 0; if not `activated`, their natural logarithms.
        rotations: N x 4, quaternions w x y z of any length but 0.
        opacities: N or N x 1, 0..1; if not `activated`, logits.
        sh: N x K x 3, coefficients of spherical harmonics, DC first, K = 1, 4, 9 or 16.
        sh_rest: N x (K - 1) x 3, if `sh` has the DC alone, N x 1 x 3.
        colors: N x 3, RGB without view dependence, nominally 0..1, instead of `sh`.
        antialiased: trained with Mip-Splatting's opacity compensation.

        Arrays are numpy's, sequences, or arrays of torch, JAX and other libraries in host memory,
        of real numbers. float32 and float64 of any strides are read in place. All of them may be
        in the memory of the context's GPU; then they are copied to the host. Gaussians with NaN,
        infinite or impossible values are not drawn; the others keep their numbers.

        Raises UsageError.
        """
        who = "Scene.from_arrays"
        given = _ffi.QsGaussians(is_activated=bool(activated), antialiased=bool(antialiased))
        on_gpu = is_on_gpu(means)
        real: Callable[..., Any] = real_gpu_array if on_gpu else real_array
        arrays = {"means": real(means, f"{who}: means", (None, 3))}
        count = arrays["means"].shape[0]
        arrays["scales"] = real(scales, f"{who}: scales", (count, 3))
        arrays["rotations"] = real(rotations, f"{who}: rotations", (count, 4))
        column = real(opacities, f"{who}: opacities")
        if column.ndim == 2 and column.shape[1] == 1:
            column = column.column() if on_gpu else column[:, 0]
        require_shape(column, f"{who}: opacities", (count,))
        arrays["opacities"] = column
        if (sh is None) == (colors is None):
            raise UsageError(f"{who}: give either sh or colors")
        if colors is not None:
            given.colors_are = _ffi.COLORS_RGB
            values = colors if on_gpu else to_numpy(colors, f"{who}: colors")
            if str(getattr(values, "dtype", "")).endswith("uint8"):
                raise UsageError(f"{who}: colors has elements of type uint8: divide them by 255")
            arrays["colors"] = real(values, f"{who}: colors", (count, 3))
        else:
            arrays["colors"] = real(sh, f"{who}: sh", (count, None, 3))
        if sh_rest is not None:
            arrays["rest"] = real(sh_rest, f"{who}: sh_rest", (count, None, 3))
        for name, array in arrays.items():
            setattr(given, name, array.struct() if on_gpu else struct_of(array))
        if on_gpu:
            given.stream = arrays["means"].stream
            owner = chosen(context, who, "cuda", arrays["means"].device)
        else:
            owner = chosen(context, who)
        handle = ctypes.c_void_p()
        with owner._use(who) as pointer:
            _ffi.call(who, "qs_scene_wrap", pointer, ctypes.byref(given), ctypes.byref(handle))
            return _scene(owner, handle, who)

    @property
    def facts(self) -> SceneFacts:
        """The facts of the scene."""
        return self._facts

    @property
    def context(self) -> Context:
        """The context in which the scene was loaded."""
        return self._context

    @property
    def bounds(self) -> Tuple[np.ndarray, np.ndarray]:
        """The lowest and the highest coordinates of the centres, world, float64; 0 if empty."""
        return (np.array(self._facts.low), np.array(self._facts.high))

    def __len__(self) -> int:
        return self._facts.gaussians

    def __bool__(self) -> bool:
        return True

    def cameras(self) -> List[Camera]:
        """The cameras of the file beside the scene. Raises InputError if there is none."""
        if not self._facts.cameras_path:
            raise InputError(f"{self._facts.path or 'the scene'}: no file of cameras was found "
                             "beside it: use read_cameras(), Camera or Camera.look_at()")
        return read_cameras(self._facts.cameras_path)

    def arrays(self, activated: bool = True, dtype: Any = "float32") -> Dict[str, np.ndarray]:
        """A copy of the N = len(scene) Gaussians, by the names of arguments of from_arrays().

        means: N x 3, world.
        scales: N x 3, standard deviations; if not `activated`, their natural logarithms.
        rotations: N x 4, quaternions w x y z of length 1.
        opacities: N, 0..1; if not `activated`, logits.
        sh: N x K x 3, coefficients of spherical harmonics, DC first, K = 1, 4, 9 or 16.

        dtype: "float32" or "float64". The scene is float32; only activated values have more digits.

        Row i has the Gaussian of number i. Rows of Gaussians that are not drawn are NaN. With the
        facts' `antialiased`, from_arrays() makes a scene of these arrays that draws the same bits,
        or the same within rounding if they are activated. Activated arrays are also arguments of
        quadsplat.torch.rasterize(), as tensors by torch.from_numpy(). Raises UsageError.
        """
        who = "Scene.arrays"
        element = element_type(dtype, f"{who}: dtype", _REALS)
        count = len(self)
        coefficients = (self._facts.sh_degree + 1) ** 2
        shapes = {"means": (count, 3), "scales": (count, 3), "rotations": (count, 4),
                  "opacities": (count,), "sh": (count, coefficients, 3)}
        wanted = _ffi.QsGaussians(is_activated=bool(activated))
        with self._context._use(who):
            pointer = self._pointer(who)
            arrays = {name: np.empty(shape, element) for name, shape in shapes.items()}
            for name, array in arrays.items():
                setattr(wanted, "colors" if name == "sh" else name, struct_of(array))
            _ffi.call(who, "qs_scene_gaussians", pointer, ctypes.byref(wanted))
        return arrays

    def edit(self, edits: Any) -> Edited:
        """Which Gaussians are selected at the end of edits, and which are left.

        edits: a list of steps, mappings of the members of docs/formats.md, section Edits; or the path of a
            file of edits. `camera` may be a Camera, and numbers may be arrays.

        The scene stays as it is: the steps scale and level do nothing. Raises InputError for steps
        that do not fit, UsageError, DeviceError, and Cancelled after Context.stop().
        """
        from ._select import edited  # which imports this module

        return edited(self, edits, "Scene.edit")

    def select(self, *steps: Any, **step: Any) -> np.ndarray:
        """The selected Gaussians, N of True or False, after steps as for edit().

            scene.select(tool="rectangle", camera=camera, pixels=[(10, 20), (90, 70)])
            scene.select({"tool": "sphere", "point": (0, 1, 2), "radius": 0.5}, {"tool": "grow"})

        step: the last step.
        """
        from ._select import edited, steps_of

        return edited(self, steps_of(steps, step, "Scene.select"), "Scene.select").selected

    def close(self) -> None:
        """Frees the scene. It cannot be used afterwards."""
        self._finalizer()

    def __enter__(self) -> Scene:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], value: Optional[BaseException],
                 traceback: Optional[TracebackType]) -> None:
        self.close()

    def __repr__(self) -> str:
        name = os.path.basename(self._facts.path) or self._facts.format
        state = "" if self._finalizer.alive else ", closed"
        return (f"<quadsplat.Scene {name}: {len(self)} Gaussians, spherical harmonics of degree "
                f"{self._facts.sh_degree}, {self._context.backend}{state}>")

    def __reduce__(self) -> Any:
        raise UsageError("Scene: it cannot be pickled: load it in each process")

    def _pointer(self, who: str) -> ctypes.c_void_p:
        """The library's scene, within a use of the context."""
        if not self._finalizer.alive:
            raise UsageError(f"{who}: the scene was closed")
        return self._scene


def load(path: Path, *, axes: Optional[str] = None, context: Optional[Context] = None) -> Scene:
    """Reads a scene of any format of the program, or the highest iteration of a model folder.

    axes: overrides the axes that the file declares, "RDF", "RUB", ...
    context: draws the scene; None: the process's, on the GPU where that works.

    Gaussians with NaN or infinite values are left out. Sentences about the file are warnings.
    Raises InputError if the file is missing or damaged, DeviceError, and UsageError.
    """
    return _load(path, axes, chosen(context, "load"), "load")


def convert(source: Union[Scene, Path], path: Path, *, sh_degree: int = _ALL_SH_DEGREES,
            keep_largest: Optional[int] = None, crop: Any = None, drop_floaters: bool = False,
            format: Optional[str] = None, overwrite: bool = False, axes: Optional[str] = None) -> None:
    """Writes a scene: .ply, .compressed.ply, .spz, .splat, .glb, by the ending of the path.

    source: a scene, or the path of one.
    sh_degree: highest degree that is written, 0..3.
    keep_largest: writes this number of Gaussians with the largest opacity times area; None: all.
    crop: (low, high), the corners of a box of the world; Gaussians with their centre outside are
        left out.
    drop_floaters: leaves out floaters, as the program's --drop-floaters.
    format: its name, instead of the ending.
    overwrite: an existing file is replaced, but never the file of the scene.
    axes: as for load(), if `source` is a path.

    The file appears whole or not at all. Raises InputError, and UsageError if the file exists.
    """
    who = "convert"
    form = _ffi.QsConversion(overwrite=bool(overwrite))
    form.sh_degree = integer(sh_degree, f"{who}: sh_degree", 0, _ALL_SH_DEGREES)
    if keep_largest is not None:
        form.keep_largest = integer(keep_largest, f"{who}: keep_largest", 1, 2**63 - 1)
    form.drops_floaters = bool(drop_floaters)
    if crop is not None:
        low, high = real_array(crop, f"{who}: crop", (2, 3)).tolist()
        if low == high == [0, 0, 0]:
            raise UsageError(f"{who}: crop is a box without size")
        form.crop_low[:], form.crop_high[:] = low, high
    if format is not None:
        form.format = encoded(format, f"{who}: format")
    target = encoded_path(path, f"{who}: path")
    is_scene = isinstance(source, Scene)
    if is_scene and axes is not None:
        raise UsageError(f"{who}: axes belongs to a path, but source is a scene")
    scene = source if isinstance(source, Scene) else _load(source, axes, chosen(None, who, "cpu"),
                                                           who)
    try:
        with scene.context._use(who):
            _ffi.call(who, "qs_convert", scene._pointer(who), target, ctypes.byref(form))
    finally:
        if not is_scene:
            scene.close()


def _load(path: Path, axes: Optional[str], context: Context, who: str) -> Scene:
    name = encoded_path(path, f"{who}: path")
    convention = None if axes is None else encoded(axes, f"{who}: axes")
    handle = ctypes.c_void_p()
    with context._use(who) as pointer:
        _ffi.call(who, "qs_scene_load", pointer, name, convention, ctypes.byref(handle))
        scene = _scene(context, handle, who)
    for sentence in scene.facts.warnings:
        warn(f"{scene.facts.path}: {sentence}", UserWarning)
    return scene


def _scene(context: Context, handle: ctypes.c_void_p, who: str) -> Scene:
    assert handle.value is not None
    scene = Scene.__new__(Scene)
    scene._context = context
    scene._scene = handle
    scene._finalizer = weakref.finalize(scene, context._handle.close_scene, handle.value)
    scene._facts = _facts(handle, who)
    return scene


def _facts(handle: ctypes.c_void_p, who: str) -> SceneFacts:
    found = _ffi.QsSceneFacts()
    _ffi.call(who, "qs_scene_facts", handle, ctypes.byref(found))
    return SceneFacts(
        found.gaussians, found.not_drawn, found.sh_degree, tuple(found.low), tuple(found.high),
        bool(found.antialiased), bool(found.white_background), _ffi.text(found.path),
        _ffi.text(found.format), found.file_bytes, _ffi.text(found.axes),
        _ffi.text(found.vertical_axis), _ffi.text(found.cameras_path),
        tuple(_ffi.text(found.warnings).splitlines()))
