# SPDX-License-Identifier: MIT
"""The functions and structs of quadsplat.h by ctypes. The structs are described there.

The library is the file that the environment variable QUADSPLAT_LIBRARY names, or else
libquadsplat.so beside this module, or else the system's libquadsplat.so.1. Calls release the GIL
unless they enqueue work on a GPU.
"""
from __future__ import annotations

import ctypes
import os
import re
from ctypes import POINTER, c_char, c_char_p, c_double, c_float, c_int32, c_int64, c_uint32
from ctypes import c_uint64, c_void_p
from pathlib import Path
from typing import Any, Tuple

from ._errors import OF_RESULT, DeviceError

#: QS_LIBRARY_VERSION of the header that this module was written for.
LIBRARY_VERSION = 1
MESSAGE_BYTES = 256

FLOAT32, FLOAT64, UINT8, INT32, UINT32, INT64, UINT64 = range(7)
MEMORY_HOST = 0
MEMORY_CUDA = 1
BACKENDS = {"auto": 0, "cpu": 1, "cuda": 2}
FIRST_GPU = -1
COLORS_SH, COLORS_RGB = 0, 1
PIPELINES = {"fast": 0, "classic": 1}
ANTIALIASED = {None: 0, True: 1, False: 2}
METRICS = {"psnr": 1, "psnr_8bit": 2, "ssim": 4, "flip": 8, "lpips": 16,
           "lpips_paper": 32}
BORDERS = {"zeros": 0, "crop": 1}
PADDINGS = {"same": BORDERS["zeros"], "valid": BORDERS["crop"]}
MOST_COPIES = 51
STAGES = ("preprocess", "bin", "sort", "blend")
RADII = {"inria": 0, "gsplat_1_4": 1, "gsplat_1_5": 2}


class QsArray(ctypes.Structure):
    _fields_ = [("data", c_void_p), ("sizes", c_int64 * 4), ("strides", c_int64 * 4),
                ("dimensions", c_uint32), ("type", c_uint32), ("memory", c_uint32),
                ("device", c_int32)]


class _Sized(ctypes.Structure):
    """A struct that begins with its size."""

    def __init__(self, **members: Any) -> None:
        super().__init__(size=ctypes.sizeof(type(self)), **members)


class QsGpu(_Sized):
    _fields_ = [("size", c_uint32), ("major", c_int32), ("minor", c_int32), ("reserved", c_uint32),
                ("total_bytes", c_uint64), ("free_bytes", c_uint64), ("name", c_char * 128),
                ("problem", c_char * 256)]


class QsReport(_Sized):
    _fields_ = [("size", c_uint32), ("gpus", c_uint32), ("threads", c_uint32),
                ("first_gpu", c_int32), ("driver", c_char * 16), ("runtime", c_char * 16),
                ("cuda_problem", c_char * 256)]


class QsMode(_Sized):
    _fields_ = [("size", c_uint32), ("is_peer", c_uint32), ("is_lossless", c_uint32),
                ("keeps_faint", c_uint32), ("name", c_char_p), ("summary", c_char_p)]


class QsGaussians(_Sized):
    _fields_ = [("size", c_uint32), ("is_activated", c_uint32), ("colors_are", c_uint32),
                ("antialiased", c_uint32), ("means", QsArray), ("scales", QsArray),
                ("rotations", QsArray), ("opacities", QsArray), ("colors", QsArray),
                ("rest", QsArray), ("stream", c_void_p)]


class QsSceneFacts(_Sized):
    _fields_ = [("size", c_uint32), ("sh_degree", c_int32), ("gaussians", c_uint64),
                ("not_drawn", c_uint64), ("file_bytes", c_uint64), ("low", c_float * 3),
                ("high", c_float * 3), ("antialiased", c_uint32), ("white_background", c_uint32),
                ("path", c_char_p), ("format", c_char_p), ("axes", c_char_p),
                ("vertical_axis", c_char_p), ("cameras_path", c_char_p), ("warnings", c_char_p)]


class QsConversion(_Sized):
    _fields_ = [("size", c_uint32), ("overwrite", c_uint32), ("sh_degree", c_int32),
                ("reserved", c_uint32), ("keep_largest", c_uint64), ("format", c_char_p),
                ("crop_low", c_float * 3), ("crop_high", c_float * 3),
                ("drops_floaters", c_uint32), ("reserved2", c_uint32)]


class QsCamera(_Sized):
    _fields_ = [("size", c_uint32), ("width", c_int32), ("height", c_int32),
                ("reserved", c_uint32), ("view_from_world", c_double * 12),
                ("focal_px", c_double * 2), ("center_px", c_double * 2), ("near_depth", c_double),
                ("model", c_char * 32), ("parameters", c_double * 16),
                ("parameter_count", c_uint32), ("reserved2", c_uint32)]


class QsSurfacePoint(ctypes.Structure):
    _fields_ = [("position", c_double * 3), ("direction", c_double * 3), ("distance", c_double),
                ("along", c_double), ("across", c_double), ("to_next", c_double)]


class QsSettings(_Sized):
    _fields_ = [("size", c_uint32), ("pipeline", c_uint32), ("cull", c_char_p),
                ("background", c_float * 3), ("splat_scale", c_float), ("dilation_px2", c_double),
                ("sh_degree", c_int32), ("antialiased", c_uint32), ("tile_px", c_int32),
                ("reserved", c_uint32)]


class QsCounts(_Sized):
    _fields_ = [("size", c_uint32), ("pipeline", c_uint32), ("tile_columns", c_int32),
                ("tile_rows", c_int32), ("tile_px", c_int32), ("threads", c_int32),
                ("gaussians", c_uint64), ("visible", c_uint64), ("tile_pairs", c_uint64),
                ("max_pairs_in_a_tile", c_uint64), ("sort_bytes", c_uint64),
                ("used_pairs", c_uint64), ("frame_ms", c_double), ("stage_ms", c_double * 4),
                ("reserved", c_double)]


class QsPicture(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("color", QsArray), ("alpha", QsArray),
                ("depth", QsArray), ("median_depth", QsArray), ("evaluated", QsArray),
                ("pairs", QsArray), ("used", QsArray), ("counts", POINTER(QsCounts)),
                ("stream", c_void_p)]


class QsLists(_Sized):
    _fields_ = [("size", c_uint32), ("tile_px", c_int32), ("tile_columns", c_int32),
                ("tile_rows", c_int32), ("gaussians", QsArray), ("depths", QsArray),
                ("means_px", QsArray), ("covariances", QsArray), ("conics", QsArray),
                ("opacities", QsArray), ("colors", QsArray), ("tile_begin", QsArray),
                ("listed", QsArray), ("reserved", c_uint64)]


class QsModeCounts(_Sized):
    _fields_ = [("size", c_uint32), ("mode", c_uint32), ("name", c_char_p),
                ("tile_pairs", c_uint64), ("visible", c_uint64)]


class QsComparison(_Sized):
    _fields_ = [("size", c_uint32), ("metrics", c_uint32), ("ssim_border", c_uint32),
                ("reserved", c_uint32), ("mask", QsArray), ("psnr", c_double),
                ("psnr_8bit", c_double), ("ssim", c_double), ("flip", c_double),
                ("reserved2", c_double), ("lpips", c_double), ("lpips_paper", c_double),
                ("lpips_weights", c_char_p)]


#: QsMemory.allocate
ALLOCATE = ctypes.CFUNCTYPE(c_void_p, c_void_p, c_uint64, c_uint32)


class QsMemory(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("user", c_void_p),
                ("allocate", ALLOCATE)]


class QsInputs(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("means", QsArray),
                ("scales", QsArray), ("rotations", QsArray), ("covariances", QsArray),
                ("opacities", QsArray), ("sh", QsArray), ("sh_rest", QsArray),
                ("channels", QsArray), ("background", QsArray), ("position", QsArray),
                ("stream", c_void_p), ("temporary", POINTER(QsMemory))]


class QsRules(_Sized):
    _fields_ = [("size", c_uint32), ("sh_degree", c_int32), ("cull", c_char_p),
                ("far_depth", c_double), ("dilation_px2", c_double), ("splat_scale", c_double),
                ("compensation_floor", c_double), ("alpha_max", c_double),
                ("radius_clip_px", c_double), ("slope_low", c_double * 2),
                ("slope_high", c_double * 2), ("antialiased", c_uint32),
                ("keeps_rotation_length", c_uint32), ("zero_color_passes", c_uint32),
                ("alpha_max_blocks", c_uint32), ("stops_at_equal", c_uint32),
                ("radius_rule", c_uint32)]


class QsStageFrame(_Sized):
    _fields_ = [("size", c_uint32), ("type", c_uint32), ("gaussians", c_uint64),
                ("listed", c_uint64), ("pairs", c_uint64), ("width", c_int32),
                ("height", c_int32), ("channels", c_uint32), ("has_depth", c_uint32),
                ("per_gaussian", c_void_p), ("per_pair", c_void_p), ("per_pixel", c_void_p),
                ("memory", c_uint32), ("device", c_int32)]


class QsMatrices(_Sized):
    _fields_ = [("size", c_uint32), ("is_clip", c_uint32), ("view", QsArray), ("lens", QsArray),
                ("position", QsArray), ("half_fov", c_double * 2), ("at", POINTER(c_double)),
                ("stream", c_void_p)]


class QsBoundary(_Sized):
    _fields_ = [("size", c_uint32), ("corners", c_uint32), ("means_px", QsArray),
                ("conics", QsArray), ("depths", QsArray), ("opacities", QsArray),
                ("colors", QsArray), ("radii", QsArray)]


class QsBlended(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("color", QsArray),
                ("alpha", QsArray), ("depth", QsArray), ("inverse_depth", QsArray)]


class QsBoundaryGradients(_Sized):
    _fields_ = [("size", c_uint32), ("ndc", c_uint32), ("means_px", QsArray),
                ("conics", QsArray), ("depths", QsArray), ("opacities", QsArray),
                ("colors", QsArray), ("channels", QsArray), ("absolute_px", QsArray),
                ("background", QsArray)]


class QsInputGradients(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("means", QsArray),
                ("scales", QsArray), ("rotations", QsArray), ("covariances", QsArray),
                ("opacities", QsArray), ("sh", QsArray), ("sh_rest", QsArray),
                ("view_from_world", QsArray), ("position", QsArray)]


class QsSimilarity(_Sized):
    _fields_ = [("size", c_uint32), ("border", c_uint32), ("a", QsArray), ("b", QsArray),
                ("ssim", QsArray), ("l1", QsArray), ("terms", QsArray), ("by_ssim", QsArray),
                ("by_l1", QsArray), ("by_a", QsArray), ("stream", c_void_p),
                ("temporary", POINTER(QsMemory))]


class QsNoise(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("factor", c_double),
                ("slope", c_double), ("middle", c_double), ("means", QsArray),
                ("log_scales", QsArray), ("rotations", QsArray), ("opacity_logits", QsArray),
                ("normals", QsArray), ("stream", c_void_p)]


class QsAdam(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("step", c_uint64), ("rate", c_double),
                ("beta1", c_double), ("beta2", c_double), ("epsilon", c_double),
                ("values", QsArray), ("gradients", QsArray), ("first", QsArray),
                ("second", QsArray), ("visible", QsArray), ("stream", c_void_p)]


class QsOption(ctypes.Structure):
    _fields_ = [("name", c_char_p), ("value", c_char_p)]


class QsTrainingState(_Sized):
    _fields_ = [("size", c_uint32), ("iteration", c_int32), ("iterations", c_int32),
                ("evaluated", c_int32), ("gaussians", c_uint64), ("loss", c_double),
                ("seconds", c_double), ("test_psnr", c_double), ("test_ssim", c_double),
                ("guard_psnr", c_double), ("guarded", c_int32), ("growth_ended", c_int32),
                ("reserved", c_uint64)]


#: The callbacks of a training run.
PROGRESS = ctypes.CFUNCTYPE(c_int32, c_void_p, POINTER(QsTrainingState))
TEXT = ctypes.CFUNCTYPE(None, c_void_p, c_char_p)


class QsTraining(_Sized):
    _fields_ = [("size", c_uint32), ("reserved", c_uint32), ("data", c_char_p),
                ("model", c_char_p), ("options", c_void_p), ("option_count", c_uint64),
                ("user", c_void_p), ("progress", PROGRESS), ("text", TEXT)]


#: The bytes of every struct in version 1 of the interface.
STRUCT_BYTES = {QsArray: 88, QsGpu: 416, QsReport: 304, QsMode: 32, QsGaussians: 552,
                QsSceneFacts: 112, QsConversion: 64, QsCamera: 320, QsSettings: 56, QsCounts: 120,
                QsPicture: 640, QsLists: 816, QsModeCounts: 32, QsComparison: 168,
                QsInputs: 904, QsRules: 120, QsMemory: 24, QsStageFrame: 80, QsBoundary: 536,
                QsBlended: 360, QsBoundaryGradients: 712, QsInputGradients: 800, QsAdam: 496,
                QsSimilarity: 728, QsMatrices: 304, QsNoise: 480,
                QsSurfacePoint: 80, QsOption: 16, QsTrainingState: 80, QsTraining: 64}

_STAGE = [c_void_p, POINTER(QsInputs), POINTER(QsCamera), POINTER(QsRules)]

#: The parameters of every function but the last, `message`. All return a result.
FUNCTIONS = {
    "qs_report": [POINTER(QsReport), c_void_p, c_uint64],
    "qs_mode": [c_uint32, POINTER(QsMode), POINTER(c_uint32)],
    "qs_context_open": [c_uint32, c_int32, c_int32, POINTER(c_void_p)],
    "qs_scene_load": [c_void_p, c_char_p, c_char_p, POINTER(c_void_p)],
    "qs_scene_wrap": [c_void_p, POINTER(QsGaussians), POINTER(c_void_p)],
    "qs_scene_facts": [c_void_p, POINTER(QsSceneFacts)],
    "qs_scene_gaussians": [c_void_p, POINTER(QsGaussians)],
    "qs_convert": [c_void_p, c_char_p, POINTER(QsConversion)],
    "qs_cameras_open": [c_char_p, POINTER(c_void_p), POINTER(c_uint64)],
    "qs_cameras_get": [c_void_p, c_uint64, POINTER(QsCamera), POINTER(c_char_p)],
    "qs_cameras_lens": [c_void_p, c_uint64, POINTER(QsCamera), POINTER(c_char_p)],
    "qs_camera_resize": [POINTER(QsCamera), c_int32, c_int32],
    "qs_render": [c_void_p, c_void_p, c_uint64, POINTER(QsSettings), c_void_p],
    "qs_lists": [c_void_p, POINTER(QsCamera), POINTER(QsSettings), POINTER(QsLists)],
    "qs_count_modes": [c_void_p, POINTER(QsCamera), POINTER(QsSettings), c_void_p, c_uint64,
                       POINTER(c_uint64)],
    "qs_select": [c_void_p, c_char_p, POINTER(QsArray), POINTER(QsArray)],
    "qs_measure": [c_void_p, POINTER(QsCamera), POINTER(QsSettings), c_void_p, c_uint64, c_void_p],
    "qs_picture_open": [c_char_p, POINTER(c_void_p), POINTER(QsArray)],
    "qs_picture_save": [POINTER(QsArray), c_char_p, c_uint32],
    "qs_compare": [c_void_p, POINTER(QsArray), POINTER(QsArray), POINTER(QsComparison)],
    "qs_project": _STAGE + [POINTER(QsMemory), POINTER(QsBoundary), POINTER(QsStageFrame)],
    "qs_blend": _STAGE + [POINTER(QsMemory), POINTER(QsBlended), POINTER(QsStageFrame)],
    "qs_forward": _STAGE + [POINTER(QsMemory), POINTER(QsBoundary), POINTER(QsBlended),
                            POINTER(QsStageFrame)],
    "qs_count_pixels": _STAGE + [POINTER(QsStageFrame), c_double, POINTER(QsArray)],
    "qs_blend_backward": _STAGE + [POINTER(QsStageFrame), POINTER(QsBlended),
                                   POINTER(QsBoundaryGradients)],
    "qs_project_backward": _STAGE + [POINTER(QsStageFrame), POINTER(QsBoundaryGradients),
                                     POINTER(QsInputGradients)],
    "qs_backward": _STAGE + [POINTER(QsStageFrame), POINTER(QsBlended),
                             POINTER(QsBoundaryGradients), POINTER(QsInputGradients)],
    "qs_ssim": [c_void_p, POINTER(QsArray), POINTER(QsArray), c_uint32, POINTER(c_double)],
    "qs_ssim_backward": [c_void_p, POINTER(QsArray), POINTER(QsArray), c_uint32, c_double,
                         POINTER(QsArray)],
    "qs_camera_of_matrices": [c_void_p, POINTER(QsMatrices), POINTER(QsCamera)],
    "qs_context_stream": [c_void_p, c_void_p],
    "qs_similarity": [c_void_p, POINTER(QsSimilarity)],
    "qs_similarity_backward": [c_void_p, POINTER(QsSimilarity)],
    "qs_noise": [c_void_p, POINTER(QsNoise)],
    "qs_covariances": [c_void_p] + [POINTER(QsArray)] * 3,
    "qs_add_view": ([c_void_p] + [POINTER(QsArray)] * 2 + [c_double] * 2 + [POINTER(QsArray)] * 2),
    "qs_neighbours": [c_void_p, POINTER(QsArray), POINTER(QsArray)],
    "qs_relocate": [c_void_p] + [POINTER(QsArray)] * 5,
    "qs_adam": [c_void_p, POINTER(QsAdam)],
    "qs_adam_all": [c_void_p, POINTER(QsAdam), c_uint64],
    "qs_train": [c_void_p, POINTER(QsTraining), POINTER(QsTrainingState)],
}

#: Functions without a message: the result, and the parameters.
PLAIN_FUNCTIONS = {
    "qs_version": (c_int32, [POINTER(c_char_p)]),
    "qs_context_close": (None, [c_void_p]),
    "qs_context_backend": (c_uint32, [c_void_p]),
    "qs_stop": (None, [c_void_p]),
    "qs_scene_close": (None, [c_void_p]),
    "qs_cameras_close": (None, [c_void_p]),
    "qs_picture_close": (None, [c_void_p]),
}


def _open_library() -> Tuple[ctypes.CDLL, ctypes.PyDLL]:
    """The library, and the same library with calls that hold the GIL."""
    beside = Path(__file__).with_name("libquadsplat.so")
    path = os.environ.get("QUADSPLAT_LIBRARY") or (
        str(beside) if beside.exists() else "libquadsplat.so.1")
    try:
        opened, holding = ctypes.CDLL(path), ctypes.PyDLL(path)
    except OSError as error:
        raise ImportError(f"quadsplat: the library {path} cannot be loaded: {error}") from error
    try:
        declare = [(name, c_int32, parameters + [c_char_p])
                   for name, parameters in FUNCTIONS.items()]
        declare += [(name, result, parameters)
                    for name, (result, parameters) in PLAIN_FUNCTIONS.items()]
        for name, result, parameters in declare:
            for function in (getattr(opened, name), getattr(holding, name)):
                function.restype = result
                function.argtypes = parameters
    except AttributeError as error:
        raise ImportError(f"quadsplat: {path} is too old for this package: {error}") from error
    version = opened.qs_version(None)
    if version != LIBRARY_VERSION:
        raise ImportError(f"quadsplat: {path} has version {version} of the interface, but this "
                          f"package needs version {LIBRARY_VERSION}")
    for struct, known in STRUCT_BYTES.items():
        if ctypes.sizeof(struct) != known:
            raise ImportError(f"quadsplat: {struct.__name__} has {ctypes.sizeof(struct)} bytes on "
                              f"this machine instead of {known}")
    return opened, holding


library, _holding = _open_library()


def _version_text() -> str:
    text = c_char_p()
    library.qs_version(ctypes.byref(text))
    return (text.value or b"").decode().split(" ")[0]


#: The version of quadsplat, "0.1.0".
VERSION = _version_text()

_PLACE = re.compile(r"^qs_\w+: (\w+(\[\d+\])?\.)?")


_Message = c_char * MESSAGE_BYTES


def call(who: str, function: str, *arguments: Any, on_gpu: bool = False) -> None:
    """Calls a function of FUNCTIONS. Raises quadsplat.Error, with `who` in the place of its name.

    on_gpu: the function enqueues work on a GPU, so the call is short and holds the GIL. Its
        callbacks would wait for the GIL each time if another thread runs.
    """
    message = _Message()
    code = getattr(_holding if on_gpu else library, function)(*arguments, message)
    if code != 0:
        sentence = message.value.decode(errors="replace") or "not enough memory"
        raise OF_RESULT.get(code, DeviceError)(_PLACE.sub(f"{who}: ", sentence, count=1))


def text(value: bytes | None) -> str:
    """A text of the library."""
    return (value or b"").decode(errors="surrogateescape")


def array_of(struct: type, count: int) -> Any:
    """An array of structs that begin with their size."""
    made = (struct * count)()
    for element in made:
        element.size = ctypes.sizeof(struct)
    return made
