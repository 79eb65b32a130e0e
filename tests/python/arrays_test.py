# SPDX-License-Identifier: MIT
"""Arrays of every kind: numpy's in all forms, sequences, torch's, and other libraries'."""
import subprocess
import sys

import numpy as np
import pytest

try:
    import torch
except ImportError:
    torch = None

COUNT = 7


def gaussians():
    random = np.random.default_rng(1)
    return {"means": random.normal(0, 0.3, (COUNT, 3)) + [0, 0, 3],
            "scales": random.uniform(0.05, 0.3, (COUNT, 3)), "rotations": random.normal(0, 1, (COUNT, 4)),
            "opacities": random.uniform(0.2, 1, COUNT), "sh": random.normal(0, 0.5, (COUNT, 4, 3))}


@pytest.fixture
def drawn(quadsplat, cpu):
    def draw(arrays):
        scene = quadsplat.Scene.from_arrays(**arrays, context=cpu)
        return quadsplat.render(scene, quadsplat.Camera(48, 40, 40)).color

    return draw


def each(arrays, form):
    return {name: form(array) for name, array in arrays.items()}


def padded(array):
    """The array as every second element of a larger one, backwards along the first axis."""
    wide = np.full(tuple(2 * size for size in array.shape), np.nan)
    wide[(slice(None, None, 2),) * array.ndim] = array[::-1]
    return wide[(slice(None, None, 2),) * array.ndim][::-1]


def unaligned(array):
    memory = bytearray(array.nbytes + 1)
    view = np.ndarray(array.shape, array.dtype, memory, 1)
    view[...] = array
    return view


def in_records(array):
    records = np.zeros(array.shape, np.dtype([("skip", "u1"), ("value", "f8")]))
    records["value"] = array
    return records["value"]


@pytest.mark.parametrize("form", [
    np.asfortranarray, padded, unaligned, in_records, lambda a: a.tolist(), lambda a: a.astype(">f8"),
    lambda a: a.astype(np.longdouble).astype(np.float64), lambda a: memoryview(np.ascontiguousarray(a))])
def test_any_form_of_doubles_draws_the_same(drawn, form):
    arrays = gaussians()
    assert np.array_equal(drawn(each(arrays, form)), drawn(arrays))


def test_float32_and_half_precision_are_read(drawn):
    arrays = gaussians()
    single = each(arrays, lambda a: a.astype(np.float32))
    assert np.array_equal(drawn(each(arrays, lambda a: a.astype(np.float32).astype(np.float64))),
                          drawn(single))
    half = each(arrays, lambda a: a.astype(np.float16))
    assert np.array_equal(drawn(half), drawn(each(half, lambda a: a.astype(np.float64))))


def test_opacities_may_be_a_column_and_values_integers(drawn):
    arrays = gaussians()
    column = {**arrays, "opacities": arrays["opacities"][:, None]}
    assert np.array_equal(drawn(column), drawn(arrays))
    whole = {**arrays, "rotations": np.tile([2, 0, 0, 0], (COUNT, 1))}
    assert np.array_equal(drawn(whole), drawn({**arrays, "rotations": whole["rotations"] * 1.0}))


def test_the_arrays_may_change_afterwards(quadsplat, cpu):
    arrays = gaussians()
    scene = quadsplat.Scene.from_arrays(**arrays, context=cpu)
    camera = quadsplat.Camera(48, 40, 40)
    before = quadsplat.render(scene, camera).color
    for array in arrays.values():
        array[...] = np.nan
    assert np.array_equal(quadsplat.render(scene, camera).color, before)


class ByInterface:
    def __init__(self, array):
        self.kept = array

    @property
    def __array_interface__(self):
        return self.kept.__array_interface__


class ByDlpack:
    def __init__(self, array, device=(1, 0)):
        self.kept, self.device = array, device

    def __dlpack__(self, **options):
        return self.kept.__dlpack__(**options)

    def __dlpack_device__(self):
        return self.device


class OnGpu:
    """An array that says to be in the memory of a GPU, as CuPy's do. Only its facts may be read."""

    def __init__(self, shape, typestr="<f4", number=0, **facts):
        self.__cuda_array_interface__ = {"shape": shape, "typestr": typestr, "data": (4096, False), "version": 3,
                                         "strides": None, **facts}
        self.number = number

    def __dlpack_device__(self):
        return 2, self.number


def test_arrays_of_other_libraries_are_read(drawn):
    arrays = gaussians()
    for form in (ByInterface, ByDlpack):
        assert np.array_equal(drawn(each(arrays, form)), drawn(arrays))


def test_memory_of_a_gpu_is_refused(quadsplat, cpu):
    for wrong in (OnGpu((COUNT, 3)), ByDlpack(gaussians()["scales"], (2, 0))):
        with pytest.raises(quadsplat.UsageError) as raised:
            quadsplat.Scene.from_arrays(**{**gaussians(), "scales": wrong}, context=cpu)
        assert str(raised.value).startswith("Scene.from_arrays: scales is in the memory of a GPU: ")
    with pytest.raises(quadsplat.UsageError, match="^compare: picture is in the memory of a GPU: "):
        quadsplat.compare(np.zeros((2, 2, 3)), OnGpu((2, 2, 3)))


@pytest.mark.skipif(torch is None, reason="torch is not installed")
def test_tensors_of_torch_are_read(drawn, quadsplat):
    arrays = gaussians()
    tensors = each(arrays, torch.tensor)
    assert np.array_equal(drawn(tensors), drawn(arrays))
    grown = each(tensors, lambda t: t.clone().requires_grad_())
    assert np.array_equal(drawn(grown), drawn(arrays))
    turned = each(tensors, lambda t: t.movedim(-1, 0).contiguous().movedim(0, -1))
    assert np.array_equal(drawn(turned), drawn(arrays))
    for kind in (torch.float16, torch.bfloat16):
        small = each(tensors, lambda t: t.to(kind))
        assert np.array_equal(drawn(small), drawn(each(small, lambda t: t.double())))
    with pytest.raises(quadsplat.UsageError, match="^Scene.from_arrays: means"):
        drawn({**tensors, "means": torch.zeros(COUNT, 3, device="meta")})
    color = torch.rand(20, 20, 3)
    assert quadsplat.compare(color, color).psnr == float("inf")


@pytest.mark.parametrize("name, wrong, sentence", [
    ("means", np.zeros((COUNT, 4)), "means has the shape (7, 4) instead of (any, 3)"),
    ("means", np.zeros(3), "means has the shape (3,) instead of (any, 3)"),
    ("means", None, "means has elements of type object instead of real numbers"),
    ("means", [["a", "b", "c"]], "means has elements of type <U1 instead of real numbers"),
    ("means", np.zeros((COUNT, 3), complex), "means has elements of type complex128 instead of"),
    ("means", np.zeros((COUNT, 3), bool), "means has elements of type bool instead of"),
    ("means", [[1, 2, 3], [1, 2]], "means cannot be read as an array: "),
    ("scales", np.zeros((6, 3)), "scales has the shape (6, 3) instead of (7, 3)"),
    ("rotations", np.zeros((COUNT, 3, 3)), "rotations has the shape (7, 3, 3) instead of (7, 4)"),
    ("opacities", np.zeros((COUNT, 2)), "opacities has the shape (7, 2) instead of (7,)"),
    ("sh", np.zeros((COUNT, 5, 3)), "5 coefficients of spherical harmonics are not 1, 4, 9 or 16"),
    ("sh", np.zeros((COUNT, 3)), "sh has the shape (7, 3) instead of (7, any, 3)"),
    ("sh_rest", np.zeros((COUNT, 3, 3)), "4 coefficients instead of the DC alone"),
    ("sh", None, "give either sh or colors"),
    ("colors", np.zeros((COUNT, 3)), "give either sh or colors")])
def test_wrong_arrays_are_refused_in_a_sentence(quadsplat, cpu, name, wrong, sentence):
    with pytest.raises(quadsplat.UsageError) as raised:
        quadsplat.Scene.from_arrays(**{**gaussians(), name: wrong}, context=cpu)
    assert str(raised.value).startswith("Scene.from_arrays: ") and sentence in str(raised.value)


def test_bytes_as_colours_are_refused(quadsplat, one):
    with pytest.raises(quadsplat.UsageError, match="colors has elements of type uint8: divide"):
        one(colors=np.array([[255, 0, 0]], np.uint8))


def on_gpu(**change):
    arrays = {"means": OnGpu((COUNT, 3)), "scales": OnGpu((COUNT, 3)), "rotations": OnGpu((COUNT, 4)),
              "opacities": OnGpu((COUNT, 1)), "sh": OnGpu((COUNT, 4, 3))}
    return {**arrays, **change}


class OnSilentGpu:
    """An array that does not say its GPU, as Numba's."""

    def __init__(self, pointer=4096):
        self.__cuda_array_interface__ = {"shape": (COUNT, 3), "typestr": "<f4", "data": (pointer, False), "version": 3}


def test_the_driver_knows_the_gpu_of_an_array_that_does_not_say_it(quadsplat, cpu, monkeypatch):
    import ctypes

    from quadsplat import _gpu_arrays

    class Driver:
        """Two GPUs; addresses below 4096 are none of theirs."""

        def cuPointerGetAttribute(self, found, attribute, pointer):
            assert attribute == 9
            ctypes.cast(found, ctypes.POINTER(ctypes.c_int))[0] = 1
            return 0 if pointer.value >= 4096 else 1

    monkeypatch.setattr(_gpu_arrays, "_cuda_driver", Driver)
    assert _gpu_arrays.GpuArray(OnSilentGpu(), "means").device == 1
    assert _gpu_arrays.GpuArray(OnSilentGpu(64), "means").device == 0
    assert _gpu_arrays.GpuArray(OnGpu((COUNT, 3), number=3), "means").device == 3
    with pytest.raises(quadsplat.UsageError, match="means: is in the memory of GPU 1, but the context has the backend cpu"):
        quadsplat.Scene.from_arrays(**on_gpu(means=OnSilentGpu(), scales=OnGpu((COUNT, 3), number=1),
                                             rotations=OnGpu((COUNT, 4), number=1), opacities=OnGpu((COUNT, 1), number=1),
                                             sh=OnGpu((COUNT, 4, 3), number=1)), context=cpu)
    monkeypatch.setattr(_gpu_arrays, "_cuda_driver", lambda: None)
    assert _gpu_arrays.GpuArray(OnSilentGpu(), "means").device == 0


@pytest.mark.parametrize("change, sentence", [
    ({}, "means: is in the memory of GPU 0, but the context has the backend cpu"),
    ({"means": OnGpu((COUNT, 3), number=3)}, "scales: is in the memory of GPU 0, but means is in the memory of GPU 3"),
    ({"scales": np.ones((COUNT, 3))}, "scales is not in the memory of the GPU that has the means"),
    ({"scales": OnGpu((COUNT, 2))}, "scales has the shape (7, 2) instead of (7, 3)"),
    ({"opacities": OnGpu((3, 1))}, "opacities has the shape (3,) instead of (7,)"),
    ({"sh": OnGpu((COUNT, 4, 3), "<f2")}, "sh has elements of type float16, which are not converted on a GPU"),
    ({"sh": OnGpu((COUNT, 4, 3), "<i4")}, "sh has elements of type int32 instead of float32 or float64"),
    ({"sh": OnGpu((COUNT, 4, 3), strides=(50, 12, 4))}, "sh has strides that are not those of whole elements"),
    ({"sh": None, "colors": OnGpu((COUNT, 3), "|u1")}, "colors has elements of type uint8 instead of float32")])
def test_gaussians_on_a_gpu_are_refused_in_a_sentence(quadsplat, cpu, change, sentence):
    with pytest.raises(quadsplat.UsageError) as raised:
        quadsplat.Scene.from_arrays(**on_gpu(**change), context=cpu)
    assert str(raised.value).startswith("Scene.from_arrays: ")
    assert sentence in str(raised.value)


def test_pictures_are_written_into_given_arrays(quadsplat, cpu):
    scene = quadsplat.Scene.from_arrays(**gaussians(), context=cpu)
    camera = quadsplat.Camera(48, 40, 40)
    expected = quadsplat.render(scene, camera, outputs=["color", "depth", "pairs"])
    planes = np.full((3, 40, 48), np.nan, np.float32)
    depth = np.full((80, 48), np.nan, np.float32)[::-2]
    given = {"color": planes.transpose(1, 2, 0), "depth": depth}
    found = quadsplat.render(scene, camera, out=given)
    assert found.color is given["color"] and found.depth is depth and found.pairs is None
    assert np.array_equal(planes, expected.color.transpose(2, 0, 1)) and np.array_equal(depth, expected.depth)
    more = quadsplat.render(scene, [camera, camera], outputs=["color", "pairs"], out=[{}, {"pairs": np.empty((3, 3), np.int64)}])
    assert more[1].pairs.dtype == np.int64
    for picture in more:
        assert np.array_equal(picture.color, expected.color) and np.array_equal(picture.pairs, expected.pairs)
    if torch is not None:
        tensor = torch.zeros(40, 48, 3, dtype=torch.uint8)
        version = tensor._version
        quadsplat.render(scene, camera, out={"color": tensor})
        assert np.array_equal(tensor.numpy(), quadsplat.render(scene, camera, dtype="uint8").color)
        assert tensor._version > version


@pytest.mark.parametrize("out, sentence", [
    (np.empty((40, 48, 3), np.float32), "out is not a dictionary of arrays by output"),
    ({"colour": np.empty((40, 48, 3), np.float32)}, "out: 'colour' is none of color"),
    ({"color": np.empty((40, 48, 4), np.float32)}, "color: has 40 x 48 x 4 elements instead of 40 x 48 x 3"),
    ({"color": np.empty((40, 48, 3))}, "color: has elements of type float64 instead of float32 or uint8"),
    ({"color": np.empty((40, 48, 3), np.float16)}, "color has elements of type float16"),
    ({"color": [[1.0]]}, "color cannot be changed in place"),
    ({"color": np.broadcast_to(np.float32(0), (40, 48, 3))}, "color cannot be changed in place"),
    ({"color": in_records(np.empty((40, 48, 3)))}, "color is not an array of whole aligned elements"),
    ({"color": OnGpu((40, 48, 3))}, "color: is in the memory of GPU 0, but the context has the backend cpu"),
    ({"color": OnGpu((40, 48, 3), data=(4096, True))}, "color cannot be changed in place"),
    ({"pairs": OnGpu((3, 3), "<i4")}, "pairs: is in the memory of a GPU, but this array must be in host memory")])
def test_arrays_that_cannot_be_filled_are_refused_in_a_sentence(quadsplat, cpu, out, sentence):
    scene = quadsplat.Scene.from_arrays(**gaussians(), context=cpu)
    with pytest.raises(quadsplat.UsageError) as raised:
        quadsplat.render(scene, quadsplat.Camera(48, 40, 40), out=out)
    assert str(raised.value).startswith("render: ") and sentence in str(raised.value)


@pytest.mark.parametrize("out, sentence", [
    ({}, "out is not a dictionary of arrays by output for each camera"), ([{}, None], "for each camera"),
    ([{}], "out has 1 dictionaries for 2 cameras")])
def test_lists_of_cameras_need_lists_of_arrays(quadsplat, cpu, out, sentence):
    scene = quadsplat.Scene.from_arrays(**gaussians(), context=cpu)
    with pytest.raises(quadsplat.UsageError, match=sentence):
        quadsplat.render(scene, [quadsplat.Camera(48, 40, 40)] * 2, out=out)
