# SPDX-License-Identifier: MIT
"""rasterize() of quadsplat.torch: values, gradients, frames that wait, every kind of tensor, refusals."""
import ctypes
import gc
import importlib
import threading

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="torch is not installed (python3-torch)")

COUNT = 30
WIDTH, HEIGHT = 40, 30
OUTPUTS = ("color", "alpha", "depth", "inverse_depth")
NAMES = ("means", "scales", "rotations", "opacities", "sh")


@pytest.fixture(scope="module")
def qt(quadsplat):
    import quadsplat.torch

    return quadsplat.torch


@pytest.fixture(scope="module")
def view(quadsplat):
    """A camera that is turned, moved, and not centred."""
    angle = 0.3
    matrix = np.eye(4)
    matrix[:3, :3] = [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    matrix[:3, 3] = -0.8, 0.1, 0.2
    return quadsplat.Camera(WIDTH, HEIGHT, (33, 36), (WIDTH / 2 + 1.5, HEIGHT / 2 - 2), matrix)


def gaussians(dtype=torch.float32, count=COUNT, coefficients=9):
    draw = torch.Generator().manual_seed(3)

    def normal(*shape):
        return torch.randn(*shape, generator=draw, dtype=torch.float64)

    def uniform(*shape):
        return torch.rand(*shape, generator=draw, dtype=torch.float64)

    values = {"means": normal(count, 3) * 0.5 + torch.tensor([0, 0, 3.0]),
              "scales": uniform(count, 3) * 0.25 + 0.03, "rotations": normal(count, 4),
              "opacities": uniform(count) * 0.7 + 0.2, "sh": normal(count, coefficients, 3) * 0.3}
    return {name: value.to(dtype).requires_grad_() for name, value in values.items()}


def weights(tensor, seed=5):
    draw = torch.Generator().manual_seed(seed)
    return torch.rand(tensor.shape, generator=draw, dtype=torch.float64).to(tensor.dtype)


def loss_of(drawn):
    """A smooth number of all pictures."""
    pictures = [picture for picture in drawn[:4] if picture is not None]
    return sum((picture * weights(picture, seed)).sum() + (picture ** 2).sum()
               for seed, picture in enumerate(pictures))


def gradients_of(loss, tensors):
    return torch.autograd.grad(loss, tensors)


def equal(a, b):
    return len(a) == len(b) and all(torch.equal(x, y) for x, y in zip(a, b))


# ---- the C interface

def through_c(quadsplat, view, values, pictures, by):
    """The pictures, and the derivatives from `by`, through ctypes and numpy alone."""
    from quadsplat import _ffi
    from quadsplat._arrays import struct_of

    def struct(kind, arrays):
        made = kind()
        for name, array in arrays.items():
            setattr(made, name, struct_of(array))
        return made

    held = []

    def allocate(_user, size, _kind):
        block = np.empty(size + 16, np.uint8)
        held.append(block)
        return (block.ctypes.data + 15) // 16 * 16

    arrays = {name: value.detach().numpy() for name, value in values.items()}
    drawn = {name: np.empty(array.shape, array.dtype) for name, array in pictures.items()}
    gradients = {name: np.empty(array.shape, array.dtype) for name, array in arrays.items()}
    gradients["view_from_world"] = np.empty((3, 4))
    centres = np.empty((len(arrays["means"]), 2), arrays["means"].dtype)
    inputs, frame = struct(_ffi.QsInputs, arrays), _ffi.QsStageFrame()
    memory = _ffi.QsMemory(allocate=_ffi.ALLOCATE(allocate))
    refer = ctypes.byref
    with quadsplat.Context("cpu") as context, context._use("test") as pointer:
        _ffi.call("test", "qs_forward", pointer, refer(inputs), refer(view._struct), None,
                  refer(memory), None, refer(struct(_ffi.QsBlended, drawn)), refer(frame))
        _ffi.call("test", "qs_backward", pointer, refer(inputs), refer(view._struct), None,
                  refer(frame), refer(struct(_ffi.QsBlended, by)),
                  refer(struct(_ffi.QsBoundaryGradients, {"means_px": centres})),
                  refer(struct(_ffi.QsInputGradients, gradients)))
    return drawn, gradients, centres


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_pictures_and_gradients_are_the_bits_of_the_c_interface(quadsplat, qt, view, dtype):
    values = gaussians(dtype)
    matrix = torch.tensor(view.view_from_world, requires_grad=True)
    points = torch.zeros(COUNT, 2, dtype=dtype, requires_grad=True)
    drawn = qt.rasterize(**values, camera=view, outputs=OUTPUTS, view_from_world=matrix,
                         position=torch.tensor(view.position), screen_points=points)
    pictures = dict(zip(OUTPUTS, drawn[:4]))
    by = {name: weights(picture).numpy() for name, picture in pictures.items()}
    torch.autograd.backward(drawn[:4], [torch.from_numpy(array) for array in by.values()])
    expected, gradients, centres = through_c(quadsplat, view, values,
                                             {k: v.detach().numpy() for k, v in pictures.items()}, by)
    for name, picture in pictures.items():
        assert np.array_equal(picture.detach().numpy(), expected[name]), name
    for name, value in values.items():
        assert np.array_equal(value.grad.numpy(), gradients[name]), name
        assert np.abs(gradients[name]).max() > 0
    assert np.array_equal(points.grad.numpy(), centres)
    assert np.array_equal(matrix.grad.numpy()[:3], gradients["view_from_world"])
    assert not matrix.grad[3].any()


# ---- counts of pixels

@pytest.mark.parametrize("boundary", [False, True])
def test_pixels_are_counted_above_a_transmittance(qt, view, boundary):
    values = gaussians()
    options = {"camera": view, "outputs": "alpha", "boundary": boundary}
    assert qt.rasterize(**values, **options).pixels is None
    every, half = (qt.rasterize(**values, **options, counts_above=above).pixels for above in (0, 0.5))
    assert every.dtype == torch.int32 and every.shape == (COUNT,) and not every.requires_grad
    assert (half <= every).all() and (half < every).any() and half.max() > 10
    alone = {name: value[4:5] for name, value in values.items()}
    drawn = qt.rasterize(**alone, **options, counts_above=0)
    assert drawn.pixels.tolist() == [int((drawn.alpha > 0).sum())] and drawn.pixels[0] > 0
    drawn.alpha.sum().backward()
    assert values["means"].grad[4].abs().max() > 0
    none = {name: value[:0] for name, value in values.items()}
    assert qt.rasterize(**none, **options, counts_above=0).pixels.shape == (0,)


# ---- differences

def check(draw, *tensors):
    """Compares the derivatives of a few numbers of each picture."""

    def numbers(*tensors):
        drawn = draw(*tensors)
        pictures = drawn if isinstance(drawn, tuple) else (drawn,)
        return tuple(torch.stack([(picture * weights(picture, seed)).sum() for seed in range(3)])
                     for picture in pictures)

    assert torch.autograd.gradcheck(numbers, tensors, eps=1e-6, atol=1e-4, rtol=1e-4, nondet_tol=0)


@pytest.mark.parametrize("boundary", [False, True])
def test_gradients_equal_differences(qt, view, boundary):
    values = gaussians(torch.float64, 8, 4)
    background = torch.tensor([0.2, 0.4, 0.9], dtype=torch.float64, requires_grad=True)

    def draw(background, *tensors):
        drawn = qt.rasterize(*tensors, camera=view, outputs=OUTPUTS, background=background,
                             boundary=boundary, rules=qt.Rules(antialiased=True, splat_scale=1.2))
        return drawn[:4]

    check(draw, background, *values.values())


@pytest.mark.parametrize("boundary", [False, True])
def test_gradients_of_channels_covariances_and_halves_of_sh_equal_differences(qt, view, boundary):
    values = gaussians(torch.float64, 8, 4)
    shape = torch.randn(8, 3, 3, generator=torch.Generator().manual_seed(1), dtype=torch.float64) * 0.15
    whole = shape @ shape.transpose(1, 2) + 0.01 * torch.eye(3, dtype=torch.float64)
    rows, columns = torch.triu_indices(3, 3)
    covariances = whole[:, rows, columns].requires_grad_()
    channels = torch.rand(8, 5, generator=torch.Generator().manual_seed(2), dtype=torch.float64,
                          requires_grad=True)

    def draw(means, covariances, opacities, channels):
        return qt.rasterize(means, None, None, opacities, covariances=covariances, channels=channels,
                            camera=view, outputs=OUTPUTS[:3], boundary=boundary)[:3]

    check(draw, values["means"], covariances, values["opacities"], channels)
    halves = [values["sh"].detach()[:, :1].clone().requires_grad_(),
              values["sh"].detach()[:, 1:].clone().requires_grad_()]

    def in_halves(sh, rest):
        given = {**values, "sh": sh}
        return qt.rasterize(**given, sh_rest=rest, camera=view, boundary=boundary).color

    check(in_halves, *halves)
    halves[0].requires_grad_(False)
    check(in_halves, *halves)


@pytest.mark.parametrize("boundary", [False, True])
def test_gradients_of_the_pose_equal_differences(qt, view, boundary):
    values = {name: value.detach() for name, value in gaussians(torch.float64, 8).items()}
    start = torch.tensor(view.view_from_world)

    def draw(move):
        x, y, z, *shift = move
        none = torch.zeros((), dtype=torch.float64)
        rows = [[none, -z, y, shift[0]], [z, none, -x, shift[1]], [-y, x, none, shift[2]], [none] * 4]
        generator = torch.stack([torch.stack(row) for row in rows])
        return qt.rasterize(**values, camera=view, view_from_world=torch.matrix_exp(generator) @ start,
                            outputs=OUTPUTS, boundary=boundary)[:4]

    check(draw, torch.tensor([0.02, -0.01, 0.03, 0.1, -0.1, 0.05], dtype=torch.float64,
                             requires_grad=True))
    place = torch.tensor([0.3, -0.4, 0.1], dtype=torch.float64, requires_grad=True)
    check(lambda position: qt.rasterize(**values, camera=view, position=position,
                                        boundary=boundary).color, place)


def test_gradients_in_single_precision_follow_differences(qt, view):
    values = gaussians()

    def loss(tensors):
        return loss_of(qt.rasterize(**tensors, camera=view, outputs=OUTPUTS))

    exact = {name: value.detach().double() for name, value in values.items()}
    gradients = gradients_of(loss(values), list(values.values()))
    for name, gradient in zip(values, gradients):
        direction = weights(gradient).double() - 0.5
        step = 1e-6 * direction
        ahead, behind = ({**exact, name: exact[name] + sign * step} for sign in (1, -1))
        difference = float(loss(ahead) - loss(behind)) / 2e-6
        assert float((gradient.double() * direction).sum()) == pytest.approx(difference, rel=1e-3), name


# ---- the boundary

def test_the_boundary_changes_no_bit_and_has_gradients_in_pixels(qt, view):
    values = gaussians()
    tensors = list(values.values())
    points = torch.full((COUNT, 2), float("nan"), requires_grad=True)
    sums = torch.full((COUNT, 2), float("nan"), requires_grad=True)
    fused = qt.rasterize(**values, camera=view, outputs=OUTPUTS, screen_points=points,
                         absolute_points=sums)
    expected = gradients_of(loss_of(fused), [*tensors, points, sums])
    split_sums = sums.detach().clone().requires_grad_()
    split = qt.rasterize(**values, camera=view, outputs=OUTPUTS, boundary=True,
                         absolute_points=split_sums)
    assert equal(split[:5], fused[:5])
    edge = split.boundary
    found = torch.autograd.grad(loss_of(split), [*tensors, edge.means_px, split_sums],
                                retain_graph=True)
    assert equal(found, expected)
    assert (found[-1] >= found[-2].abs() - 1e-5).all() and (found[-1] > found[-2].abs() + 1e-4).any()
    assert [tuple(tensor.shape) for tensor in edge] == [
        (COUNT, 2), (COUNT, 3), (COUNT,), (COUNT,), (COUNT, 3)]
    loss = edge.depths.sum() + edge.conics[:, 0].sum() + edge.opacities.sum() + edge.colors.sum()
    by = gradients_of(loss, tensors)
    assert all(gradient.abs().max() > 0 for gradient in by)
    with_channels = qt.rasterize(*tensors[:4], channels=torch.ones(COUNT, 1), camera=view, boundary=True)
    assert with_channels.boundary.colors is None and with_channels.color.shape == (HEIGHT, WIDTH, 1)


def test_radii_follow_their_rule_in_every_mode(qt, view):
    values = gaussians()
    first = {}
    for rule in ("inria", "gsplat_1_4", "gsplat_1_5"):
        for mode in ("3dgs", "quadbox", "exact"):
            radii = qt.rasterize(**values, camera=view, rules=qt.Rules(cull=mode, radius_rule=rule)).radii
            assert radii.dtype == torch.int32 and not radii.requires_grad
            assert torch.equal(radii, first.setdefault(rule, radii))
    assert torch.equal(first["inria"][:, 0], first["inria"][:, 1])
    assert not torch.equal(first["gsplat_1_5"][:, 0], first["gsplat_1_5"][:, 1])


# ---- equal bits

def test_runs_lossless_modes_and_numbers_of_threads_give_the_same_bits(quadsplat, qt, view):
    def run(**options):
        values = gaussians(count=500)
        drawn = qt.rasterize(**values, camera=view, outputs=OUTPUTS, **options)
        return [*drawn[:4], *gradients_of(loss_of(drawn), list(values.values()))]

    expected = run()
    assert equal(run(), expected)
    lossless = [mode.name for mode in quadsplat.modes()
                if mode.is_lossless and not mode.keeps_faint and mode.name != "reference"]
    assert len(lossless) > 2
    for mode in lossless:
        assert equal(run(rules=qt.Rules(cull=mode)), expected), mode
    for threads in (1, 3):
        with quadsplat.Context("cpu", threads=threads) as context:
            assert equal(run(context=context), expected)


# ---- frames that wait

def test_many_frames_wait_for_their_backward_passes(qt, view):
    values = gaussians()
    tensors = list(values.values())
    alone = [gradients_of(loss_of(qt.rasterize(**values, camera=view.resized(size, size))), tensors)
             for size in (8, 20, 33)]
    waiting = [loss_of(qt.rasterize(**values, camera=view.resized(size, size))) for size in (8, 20, 33)]
    gc.collect()
    for loss, expected in reversed(list(zip(waiting, alone))):
        assert equal(torch.autograd.grad(loss, tensors, retain_graph=True), expected)
        assert equal(gradients_of(loss, tensors), expected)
        with pytest.raises(RuntimeError, match="second time"):
            gradients_of(loss, tensors)


@pytest.mark.parametrize("boundary", [False, True])
@pytest.mark.parametrize("name", NAMES)
def test_a_change_in_place_is_noticed(qt, view, name, boundary):
    values = gaussians()
    loss = loss_of(qt.rasterize(**values, camera=view, boundary=boundary))
    with torch.no_grad():
        values[name] += 1
    with pytest.raises(RuntimeError, match="modified by an inplace operation"):
        loss.backward()


def test_gradients_have_no_gradients(qt, view):
    values = gaussians()
    loss = loss_of(qt.rasterize(**values, camera=view))
    gradient = torch.autograd.grad(loss, values["means"], create_graph=True)[0]
    with pytest.raises(RuntimeError, match="once_differentiable"):
        gradient.sum().backward()


def test_saved_memory_may_move(qt, view):
    values = gaussians()
    tensors = list(values.values())
    expected = gradients_of(loss_of(qt.rasterize(**values, camera=view, outputs=OUTPUTS)), tensors)
    with torch.autograd.graph.saved_tensors_hooks(lambda tensor: tensor.numpy().copy(), torch.from_numpy):
        loss = loss_of(qt.rasterize(**values, camera=view, outputs=OUTPUTS))
    assert equal(gradients_of(loss, tensors), expected)
    from torch.utils.checkpoint import checkpoint

    again = checkpoint(lambda *given: qt.rasterize(*given, camera=view, outputs=OUTPUTS)[:4], *tensors,
                       use_reentrant=False)
    assert equal(gradients_of(loss_of(again), tensors), expected)


def test_nothing_is_kept_without_gradients(qt, view):
    values = gaussians()
    with torch.no_grad():
        color = qt.rasterize(**values, camera=view).color
    assert color.grad_fn is None
    fixed = {name: value.detach() for name, value in values.items()}
    assert torch.equal(qt.rasterize(**fixed, camera=view).color, color)
    only = qt.rasterize(**{**fixed, "opacities": values["opacities"]}, camera=view)
    only.color.sum().backward()
    assert values["opacities"].grad.abs().max() > 0 and values["means"].grad is None
    only = qt.rasterize(**values, camera=view, outputs=["color", "alpha"])
    assert only.depth is None and gradients_of(only.alpha.sum(), values["means"])[0].abs().max() > 0


def test_threads_draw_and_differentiate_at_the_same_time(qt, view):
    def run():
        values = gaussians()
        return gradients_of(loss_of(qt.rasterize(**values, camera=view)), list(values.values()))

    expected, found = run(), [None] * 6

    def work(number):
        found[number] = run()

    threads = [threading.Thread(target=work, args=(number,)) for number in range(len(found))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(equal(result, expected) for result in found)


def test_an_error_while_memory_is_allocated_reaches_the_caller(qt, view, monkeypatch):
    values = gaussians()
    real = torch.empty

    def empty(*shape, **options):
        if options.get("dtype") == torch.uint8:
            raise MemoryError("no block")
        return real(*shape, **options)

    monkeypatch.setattr(torch, "empty", empty)
    importlib.import_module("quadsplat.torch._memory").free_all()  # or the frame takes a kept block
    with pytest.raises(MemoryError, match="no block"):
        qt.rasterize(**values, camera=view)
    monkeypatch.undo()
    assert qt.rasterize(**values, camera=view).color.isfinite().all()


# ---- kinds of tensors

def strided(tensor):
    """The tensor as a part of a larger one, with its axes in another order in memory."""
    tensor = tensor.detach()
    wide = torch.full([2 * size for size in reversed(tensor.shape)], float("nan"), dtype=tensor.dtype)
    view = wide[(slice(None, None, 2),) * tensor.dim()].permute(*reversed(range(tensor.dim())))
    view.copy_(tensor)
    assert not view.is_contiguous() or tensor.dim() == 1
    return view.requires_grad_()


def test_tensors_of_any_strides_give_the_same_bits(qt, view):
    values = gaussians()
    expected = qt.rasterize(**values, camera=view)
    by = gradients_of(loss_of(expected), list(values.values()))
    turned = {name: strided(value) for name, value in values.items()}
    found = qt.rasterize(**turned, camera=view)
    assert torch.equal(found.color, expected.color)
    assert equal(gradients_of(loss_of(found), list(turned.values())), by)


def test_expanded_inputs_and_gradients_are_read(qt, view):
    values = gaussians()
    one = torch.tensor([[0.1, 0.2, 0.15]], requires_grad=True)
    loss_of(qt.rasterize(**{**values, "scales": one.expand(COUNT, 3)}, camera=view)).backward()
    copies = one.detach().repeat(COUNT, 1).requires_grad_()
    loss_of(qt.rasterize(**{**values, "scales": copies}, camera=view)).backward()
    assert torch.allclose(one.grad, copies.grad.sum(0, keepdim=True), rtol=1e-5)
    # The gradient of a sum is an expanded tensor.
    drawn = qt.rasterize(**values, camera=view, outputs=OUTPUTS)
    whole = gradients_of(sum(picture.sum() for picture in drawn[:4]), values["means"])
    drawn = qt.rasterize(**values, camera=view, outputs=OUTPUTS)
    assert equal(torch.autograd.grad(drawn[:4], values["means"], [torch.ones_like(p) for p in drawn[:4]]),
                 whole)


def test_half_precision_is_converted_and_a_column_of_opacities_is_taken(qt, view):
    values = gaussians()
    for kind in (torch.float16, torch.bfloat16):
        halves = {name: value.detach().to(kind).requires_grad_() for name, value in values.items()}
        drawn = qt.rasterize(**halves, camera=view)
        same = qt.rasterize(**{name: value.float() for name, value in halves.items()}, camera=view)
        assert drawn.color.dtype == torch.float32 and torch.equal(drawn.color, same.color)
        drawn.color.sum().backward()
        assert all(value.grad.dtype == kind and value.grad.abs().max() > 0 for value in halves.values())
    column = values["opacities"].detach()[:, None].requires_grad_()
    drawn = qt.rasterize(**{**values, "opacities": column}, camera=view)
    drawn.color.sum().backward()
    assert column.grad.shape == (COUNT, 1)


def test_colour_in_planes_has_the_same_values(qt, view):
    values = gaussians()
    flat = qt.rasterize(**values, camera=view)
    by = gradients_of((flat.color * weights(flat.color)).sum(), values["means"])
    planes = qt.rasterize(**values, camera=view, planar=True)
    assert planes.color.shape == (3, HEIGHT, WIDTH) and planes.color.is_contiguous()
    assert torch.equal(planes.color.permute(1, 2, 0), flat.color)
    scaled = planes.color.permute(1, 2, 0) * weights(flat.color)
    assert equal(gradients_of(scaled.sum(), values["means"]), by)


@pytest.mark.parametrize("boundary", [False, True])
@pytest.mark.parametrize("rest", [False, True])
def test_no_gaussians_are_a_background(qt, view, boundary, rest):
    empty = gaussians(count=0)
    background = torch.tensor([0.1, 0.5, 0.9], requires_grad=True)
    given = {**empty}
    if rest:
        given.update(sh=torch.zeros(0, 1, 3, requires_grad=True),
                     sh_rest=torch.zeros(0, 8, 3, requires_grad=True))
    drawn = qt.rasterize(**given, camera=view, background=background, boundary=boundary, outputs=OUTPUTS)
    assert torch.equal(drawn.color, background.detach().expand(HEIGHT, WIDTH, 3))
    assert not drawn.alpha.any() and drawn.radii.shape == (0, 2)
    loss_of(drawn).backward()
    assert all(value.grad.shape == value.shape for value in given.values())
    assert background.grad.abs().min() > 0


@pytest.mark.parametrize("rest", [torch.zeros(COUNT, 0, 3), None])
def test_sh_of_degree_0_may_have_an_empty_rest(qt, view, rest):
    values = gaussians(coefficients=1)
    rest = None if rest is None else rest.requires_grad_()
    drawn = qt.rasterize(**values, sh_rest=rest, camera=view)
    drawn.color.sum().backward()
    assert rest is None or rest.grad.shape == rest.shape


def test_values_that_are_not_finite_are_not_drawn_and_have_gradient_0(qt, view):
    values = gaussians()
    expected = qt.rasterize(**{name: value[3:] for name, value in values.items()}, camera=view)
    by = gradients_of(loss_of(expected), values["means"])[0]
    broken = {name: value.detach().clone() for name, value in values.items()}
    broken["means"][0, 1] = float("nan")
    broken["scales"][1, 2] = float("inf")
    broken["sh"][2, 0, 0] = float("nan")
    broken = {name: value.requires_grad_() for name, value in broken.items()}
    drawn = qt.rasterize(**broken, camera=view)
    assert torch.equal(drawn.color, expected.color)
    gradients = gradients_of(loss_of(drawn), list(broken.values()))
    assert torch.equal(gradients[0][3:], by[3:])
    assert all(not gradient[:3].any() for gradient in gradients)


# ---- refusals

@pytest.mark.parametrize("change, sentence", [
    ({"means": np.zeros((COUNT, 3))}, "means is a ndarray instead of a torch.Tensor"),
    ({"means": torch.zeros(COUNT, 3, dtype=torch.int32)}, "means has elements of type int32 instead of"),
    ({"means": torch.zeros(COUNT, 3, device="meta")}, "means is on the device meta: "),
    ({"means": torch.zeros(COUNT, 3).to_sparse()}, "means is sparse: convert it by .to_dense()"),
    ({"means": torch.zeros(())}, "means has 0 dimensions"),
    ({"means": torch.zeros(3)}, "means"),
    ({"means": torch.zeros(1, 1, 1, 1, 3)}, "means has 5 dimensions"),
    ({"scales": torch.zeros(COUNT, 3, dtype=torch.float64)},
     "scales has elements of type float64, but means has float32"),
    ({"scales": torch.zeros(COUNT, 2)}, "scales"),
    ({"scales": None}, "scales"),
    ({"opacities": None}, "opacities are not given"),
    ({"opacities": torch.zeros(COUNT, 2)}, "opacities"),
    ({"sh": torch.zeros(COUNT, 5, 3)}, "5 coefficients"),
    ({"sh": None}, "sh"),
    ({"channels": torch.zeros(COUNT, 3)}, "sh"),
    ({"sh": None, "channels": torch.zeros(COUNT, 33)}, "33 channels are not between 1 and 32"),
    ({"sh": None, "channels": torch.zeros(())}, "channels has 0 dimensions"),
    ({"covariances": torch.zeros(COUNT, 6)}, "scales: is given, and so are covariances"),
    ({"background": torch.zeros(4)}, "background"),
    ({"screen_points": torch.zeros(COUNT, 3)}, "screen_points has the shape (30, 3) instead of (30, 2)"),
    ({"screen_points": torch.zeros(COUNT, 2), "boundary": True},
     "screen_points is given, and so is boundary"),
    ({"view_from_world": torch.zeros(3, 3)}, "view_from_world has the shape (3, 3) instead of"),
    ({"view_from_world": 2 * torch.eye(4)}, "view_from_world has the last row"),
    ({"view_from_world": torch.full((3, 4), float("nan"))}, "view_from_world: its rotation is not"),
    ({"camera": "first"}, "camera is 'first' instead of a quadsplat.Camera"),
    ({"counts_above": 1}, "counts_above: 1.0 is not at least 0 and below 1"), ({"counts_above": "x"}, "counts_above is 'x'"),
    ({"outputs": "colour"}, "outputs: 'colour' is none of color, alpha, depth, inverse_depth"),
    ({"rules": {"mode": "3dgs"}}, "rules is {'mode': '3dgs'} instead of quadsplat.torch.Rules"),
    ({"context": 3}, "context is 3 instead of a quadsplat.Context")])
def test_wrong_arguments_are_refused_in_a_sentence(quadsplat, qt, view, change, sentence):
    given = {**{name: value.detach() for name, value in gaussians().items()}, "camera": view, **change}
    with pytest.raises(quadsplat.UsageError) as raised:
        qt.rasterize(**given)
    assert str(raised.value).startswith("rasterize: ") and sentence in str(raised.value)


@pytest.mark.parametrize("change, sentence", [
    ({"cull": "best"}, "cull: 'best' is none of"), ({"cull": "reference"}, "cull"),
    ({"sh_degree": 4}, "rules.sh_degree: 4 is not between 0 and 3"), ({"alpha_max": 1.0}, "largest alpha"),
    ({"dilation_px2": -1}, "dilation"), ({"splat_scale": 0}, "scale of splats"),
    ({"radius_rule": "3dgs"}, "rules.radius_rule: '3dgs' is none of"),
    ({"slopes": (1, 2)}, "rules.slopes is (1, 2) instead of 4 numbers"),
    ({"far_depth": "far"}, "rules.far_depth is 'far' instead of a number")])
def test_wrong_rules_are_refused_in_a_sentence(quadsplat, qt, view, change, sentence):
    with pytest.raises(quadsplat.UsageError) as raised:
        qt.rasterize(**gaussians(), camera=view, rules=qt.Rules(**change))
    assert str(raised.value).startswith("rasterize: ") and sentence in str(raised.value)


def test_usual_rules_are_those_of_the_header(qt):
    import re

    from conftest import ROOT
    from quadsplat.torch import _rules

    header = (ROOT / "src" / "quadsplat" / "quadsplat.h").read_text()
    usual = re.search(r"#define QS_RULES(.*?)\n\n", header, re.S).group(1).replace("\\", "")
    words = re.sub(r"[{}\s]", "", usual).split(",")
    struct = _rules.struct_of("test", qt.Rules())
    numbers = [struct.sh_degree, 0, struct.far_depth, struct.dilation_px2, struct.splat_scale,
               struct.compensation_floor, struct.alpha_max, struct.radius_clip_px, *struct.slope_low,
               *struct.slope_high, struct.antialiased, struct.keeps_rotation_length,
               struct.zero_color_passes, struct.alpha_max_blocks, struct.stops_at_equal]
    assert words[0] == "sizeof(QsRules)" and words[1] == "QS_ALL_SH_DEGREES" and numbers[0] == 3
    assert numbers[1:] == [float(word) for word in words[2:-1]]
    assert words[-1] == "QS_RADII_INRIA" and struct.radius_rule == 0 and struct.cull == b"quadbox"


def test_torch_is_imported_by_this_module_alone(python):
    assert python("import sys, quadsplat; print('torch' in sys.modules)").strip() == "False"
    assert python("import sys, quadsplat.torch; print('torch' in sys.modules)").strip() == "True"


def test_everything_public_is_documented_and_typed(qt):
    import inspect

    for name in qt.__all__:
        thing = getattr(qt, name)
        assert inspect.getdoc(thing), name
    for parameter in inspect.signature(qt.rasterize).parameters.values():
        assert parameter.annotation is not parameter.empty
        assert f"{parameter.name}:" in qt.rasterize.__doc__ or f" {parameter.name}" in qt.rasterize.__doc__


def test_rules_take_the_older_name_of_cull(qt):
    with pytest.warns(DeprecationWarning, match="Rules: mode is called cull now"):
        assert qt.Rules(mode="adr", sh_degree=1) == qt.Rules(cull="adr", sh_degree=1)
    assert qt.Rules("adr")._replace(cull="exact").cull == "exact"


def test_kept_memory_is_used_again_and_freed(qt, view):
    memory = importlib.import_module("quadsplat.torch._memory")
    gc.collect()
    memory.free_all()

    def kept():
        return {block.tensor.data_ptr() for blocks in memory._blocks.values() for block in blocks}

    def draw_and_drop():
        qt.rasterize(**gaussians(), camera=view)
        gc.collect()

    draw_and_drop()
    first = kept()
    assert len(first) == 3
    memory.free_unused()  # used since the start
    draw_and_drop()
    assert kept() == first
    memory.free_unused()
    memory.free_unused()
    assert not kept()
    two = [qt.rasterize(**gaussians(), camera=view) for _ in range(4)]  # frames that wait have blocks of their own
    expected = two[0].color.detach().clone()
    del two[0]
    gc.collect()
    assert equal(qt.rasterize(**gaussians(), camera=view).color, expected) and equal(two[2].color, expected)


def test_empty_cache_frees_unused_memory(qt, monkeypatch):
    memory = importlib.import_module("quadsplat.torch._memory")
    calls = []
    monkeypatch.setattr(torch.cuda, "empty_cache", lambda: calls.append("torch"))
    monkeypatch.setattr(memory, "free_unused", lambda: calls.append("quadsplat"))
    memory.follow_empty_cache()
    memory.follow_empty_cache()
    torch.cuda.empty_cache()
    assert calls == ["quadsplat", "torch"]
