# SPDX-License-Identifier: MIT
"""The drop-in for diff_gaussian_rasterization and its variants, simple_knn and fused_ssim."""
import inspect
import math

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="torch is not installed (python3-torch)")

WIDTH, HEIGHT, FOCAL = 48, 36, (40.0, 44.0)
COUNT = 24


@pytest.fixture(scope="module")
def inria(quadsplat):
    from quadsplat.dropin import _inria

    return _inria


@pytest.fixture
def variant(monkeypatch):
    return lambda name: monkeypatch.setenv("QUADSPLAT_DROPIN_VARIANT", name)


def gaussians(dtype=torch.float32, count=COUNT, spread=0.5, coefficients=4):
    draw = torch.Generator().manual_seed(7)

    def of(function, *shape):
        return function(*shape, generator=draw, dtype=torch.float64)

    values = {"means3D": of(torch.randn, count, 3) * spread + torch.tensor([0, 0, 3.0]),
              "opacities": of(torch.rand, count, 1) * 0.6 + 0.2,
              "shs": of(torch.randn, count, coefficients, 3) * 0.3,
              "scales": of(torch.rand, count, 3) * 0.2 + 0.05,
              "rotations": torch.nn.functional.normalize(of(torch.randn, count, 4))}
    return {name: value.to(dtype).requires_grad_() for name, value in values.items()}


def projection(offset=(0.0, 0.0)):
    """The 4 x 4 perspective projection of the published trainer, transposed."""
    near, far = 0.01, 100.0
    matrix = torch.zeros(4, 4, dtype=torch.float64)
    matrix[0, 0], matrix[1, 1] = 2 * FOCAL[0] / WIDTH, 2 * FOCAL[1] / HEIGHT
    matrix[0, 2], matrix[1, 2] = offset
    matrix[2, 2], matrix[2, 3], matrix[3, 2] = far / (far - near), -far * near / (far - near), 1
    return matrix.T


def pose():
    angle = 0.2
    matrix = torch.eye(4, dtype=torch.float64)
    matrix[0, 0] = matrix[2, 2] = math.cos(angle)
    matrix[0, 2], matrix[2, 0] = math.sin(angle), -math.sin(angle)
    matrix[:3, 3] = torch.tensor([-0.6, 0.1, 0.2])
    return matrix


def settings(inria, dtype=torch.float32, offset=(0.0, 0.0), **changes):
    view = pose()
    fields = {"image_height": HEIGHT, "image_width": WIDTH, "tanfovx": WIDTH / (2 * FOCAL[0]),
              "tanfovy": HEIGHT / (2 * FOCAL[1]), "bg": torch.tensor([0.1, 0.3, 0.6]).to(dtype),
              "scale_modifier": 1.0, "viewmatrix": view.T.to(dtype),
              "projmatrix": (view.T @ projection(offset)).to(dtype), "sh_degree": 1,
              "campos": torch.inverse(view)[:3, 3].to(dtype), "prefiltered": False, "debug": False}
    return inria.GaussianRasterizationSettings(**{**fields, **changes})


def draw(inria, values, view, means2D=None, **others):
    if means2D is None:
        means2D = torch.zeros_like(values["means3D"], requires_grad=True)
    return inria.GaussianRasterizer(raster_settings=view)(means2D=means2D, **values, **others)


def weights(tensor, seed=3):
    generator = torch.Generator().manual_seed(seed)
    return torch.rand(tensor.shape, generator=generator, dtype=torch.float64).to(tensor.dtype)


def check(function, *tensors):
    assert torch.autograd.gradcheck(
        lambda *given: torch.stack([(picture * weights(picture, seed)).sum()
                                    for picture in function(*given) for seed in range(3)]),
        tensors, eps=1e-6, atol=1e-4, rtol=1e-4, nondet_tol=0)


def own_camera(quadsplat, **changes):
    return quadsplat.Camera(WIDTH, HEIGHT, FOCAL, **{"view_from_world": pose().numpy(), **changes})


# ---- values

def test_fields_and_arguments_have_the_names_and_order_of_the_original(inria):
    assert inria.GaussianRasterizationSettings._fields[:12] == (
        "image_height", "image_width", "tanfovx", "tanfovy", "bg", "scale_modifier", "viewmatrix",
        "projmatrix", "sh_degree", "campos", "prefiltered", "debug")
    assert inria.GaussianRasterizationSettings._fields[12] == "antialiasing"
    names = list(inspect.signature(inria.GaussianRasterizer.forward).parameters)[1:]
    assert names[:8] == ["means3D", "means2D", "opacities", "shs", "colors_precomp", "scales",
                         "rotations", "cov3D_precomp"]


def test_the_picture_is_that_of_rasterize(quadsplat, inria):
    from quadsplat.torch import Rules, rasterize

    values = gaussians()
    color, radii = draw(inria, values, settings(inria, scale_modifier=1.5))
    own = rasterize(values["means3D"], values["scales"], values["rotations"], values["opacities"],
                    values["shs"], camera=own_camera(quadsplat), background=torch.tensor([0.1, 0.3, 0.6]),
                    rules=Rules(cull="3dgs", sh_degree=1, splat_scale=1.5, normalises_rotations=False))
    assert color.shape == (3, HEIGHT, WIDTH) and color.is_contiguous()
    assert torch.allclose(color, own.color.permute(2, 0, 1), atol=1e-5)
    assert radii.dtype == torch.int32 and torch.equal(radii, own.radii[:, 0])


def test_radii_are_three_sigma_and_the_same_in_every_mode(inria, monkeypatch):
    values = gaussians()
    with torch.no_grad():
        values["means3D"][0] = torch.tensor([0, 0, -4.0])
    _, radii = draw(inria, values, settings(inria))
    assert radii[0] == 0 and (radii[1:] > 0).sum() > 15
    for mode in ("quadbox", "exact", "adr"):
        monkeypatch.setenv("QUADSPLAT_DROPIN_CULL", mode)
        assert torch.equal(draw(inria, values, settings(inria))[1], radii)
    from quadsplat.torch import rasterize

    one = {name: value[1:2] for name, value in values.items()}
    import quadsplat

    edge = rasterize(one["means3D"], one["scales"], one["rotations"], one["opacities"], one["shs"],
                     camera=own_camera(quadsplat), boundary=True).boundary
    a, b, c = edge.conics[0].double().tolist()
    smallest = (a + c) / 2 - math.sqrt(((a - c) / 2) ** 2 + b * b)
    assert radii[1] == math.ceil(3 / math.sqrt(smallest))


def test_gradients_of_means2d_are_in_normalised_device_coordinates(quadsplat, inria):
    from quadsplat.torch import Rules, rasterize

    values = gaussians()
    start = torch.zeros(COUNT, 3, requires_grad=True)
    means2D = start + 0  # as trainers make it
    means2D.retain_grad()
    color, _ = draw(inria, values, settings(inria), means2D)
    (color * weights(color)).sum().backward()
    points = torch.zeros(COUNT, 2, requires_grad=True)
    own = rasterize(values["means3D"], values["scales"], values["rotations"], values["opacities"],
                    values["shs"], camera=own_camera(quadsplat), screen_points=points, planar=True,
                    background=torch.tensor([0.1, 0.3, 0.6]),
                    rules=Rules(cull="3dgs", sh_degree=1, normalises_rotations=False))
    (own.color * weights(own.color)).sum().backward()
    assert torch.allclose(means2D.grad[:, 0], points.grad[:, 0] * WIDTH / 2, rtol=1e-3, atol=1e-2)
    assert torch.allclose(means2D.grad[:, 1], points.grad[:, 1] * HEIGHT / 2, rtol=1e-3, atol=1e-2)
    assert not means2D.grad[:, 2].any() and points.grad.abs().max() > 0.1


def test_colours_and_covariances_replace_their_pairs(inria):
    values = gaussians()
    rotation = torch.nn.functional.normalize(values["rotations"].detach())
    w, x, y, z = rotation.unbind(1)
    matrix = torch.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                          2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                          2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], 1)
    half = matrix.reshape(-1, 3, 3) * (1.5 * values["scales"].detach())[:, None]
    whole = half @ half.transpose(1, 2)
    rows, columns = torch.triu_indices(3, 3)
    covariances = whole[:, rows, columns].requires_grad_()
    view = settings(inria, scale_modifier=1.5)
    expected, _ = draw(inria, values, view)
    given = {name: values[name] for name in ("means3D", "opacities", "shs")}
    found, _ = draw(inria, {**given, "cov3D_precomp": covariances}, view)
    assert torch.allclose(found, expected, atol=1e-4)
    colors = torch.rand(COUNT, 3, requires_grad=True)
    found, _ = draw(inria, {"means3D": values["means3D"], "opacities": values["opacities"],
                            "colors_precomp": colors, "cov3D_precomp": covariances}, view)
    found.sum().backward()
    assert colors.grad.abs().max() > 0 and covariances.grad.abs().max() > 0


def test_the_dc_may_be_apart(inria, variant):
    values = gaussians()
    view = settings(inria, antialiasing=False)
    expected = draw(inria, values, view)
    shs = values.pop("shs").detach()
    dc, rest = shs[:, :1].clone().requires_grad_(), shs[:, 1:].clone().requires_grad_()
    found = draw(inria, {**values, "dc": dc, "shs": rest}, view)
    assert all(torch.equal(a, b) for a, b in zip(found, expected)) and len(found) == 3
    found[0].sum().backward()
    assert dc.grad.abs().max() > 0 and rest.grad.abs().max() > 0


def test_an_off_centre_projection_moves_the_centre(quadsplat, inria):
    values = gaussians()
    x, y = 0.2, -0.1
    color, _ = draw(inria, values, settings(inria, offset=(x, y)))
    from quadsplat.torch import Rules, rasterize

    own = rasterize(values["means3D"], values["scales"], values["rotations"], values["opacities"],
                    values["shs"], background=torch.tensor([0.1, 0.3, 0.6]), planar=True,
                    camera=own_camera(quadsplat, center_px=(((x + 1) * WIDTH - 1) / 2,
                                                            ((y + 1) * HEIGHT - 1) / 2)),
                    rules=Rules(cull="3dgs", sh_degree=1, normalises_rotations=False))
    assert torch.allclose(color, own.color, atol=1e-4)


def test_points_in_front_of_the_near_plane_are_marked(inria):
    points = torch.tensor([[0, 0, 3.0], [0, 0, -3.0], [0.6, -0.1, 0.35]])
    z = (points.double() @ pose()[2, :3] + pose()[2, 3]) > 0.2
    found = inria.GaussianRasterizer(settings(inria)).markVisible(points)
    assert found.dtype == torch.bool and found.tolist() == z.tolist() and found.tolist()[:2] == [True, False]


# ---- variants

def test_variants_follow_from_the_settings(inria, variant):
    values = gaussians()
    assert len(draw(inria, values, settings(inria))) == 2
    color, radii, inverse = draw(inria, values, settings(inria, antialiasing=True))
    assert inverse.shape == (1, HEIGHT, WIDTH) and inverse.max() > 0.1
    posed = draw(inria, values, settings(inria, projmatrix_raw=projection().float()))
    assert [tuple(result.shape) for result in posed] == [
        (3, HEIGHT, WIDTH), (COUNT,), (1, HEIGHT, WIDTH), (1, HEIGHT, WIDTH), (COUNT,)]
    variant("mcmc")
    color, radii, used = draw(inria, values, settings(inria))
    assert torch.equal(used, radii > 0)
    variant("original")
    assert len(draw(inria, values, settings(inria, antialiasing=True))) == 2


def test_depths_of_the_variants_are_sums_by_weight(inria):
    values = {name: value[:1] for name, value in gaussians().items()}
    with torch.no_grad():
        values["opacities"][:] = 0.5
    inverse = draw(inria, values, settings(inria, antialiasing=False))[2]
    _, _, depth, opacity, touched = draw(inria, values, settings(inria, projmatrix_raw=projection()))
    z = float(values["means3D"][0].double() @ pose()[2, :3] + pose()[2, 3])
    assert torch.allclose(depth, opacity * z, atol=1e-5)
    assert torch.allclose(inverse, opacity / z, atol=1e-5)
    # A lone Gaussian of opacity 0.5 leaves more than half in every pixel that it is blended in.
    assert touched.dtype == torch.int32
    assert abs(int(touched[0]) - int((opacity > 0).sum())) <= 1


def test_touched_pixels_end_where_half_is_covered(inria):
    values = gaussians(count=3, spread=0)
    with torch.no_grad():
        values["means3D"][:, 2] = torch.tensor([2.0, 3.0, 4.0])
        values["scales"][:] = 2
        values["opacities"][:] = torch.tensor([[0.3], [0.1], [0.5]])
    touched = draw(inria, values, settings(inria, projmatrix_raw=projection()))[4]
    # 0.7 is behind the first Gaussian, 0.63 behind the second, and 0.31 behind the third in the middle.
    assert touched[0] == touched[1] == WIDTH * HEIGHT and 0 <= touched[2] < WIDTH * HEIGHT


def test_absgs_has_absolute_sums_and_weights(inria):
    values = gaussians()
    four = torch.zeros(COUNT, 4, requires_grad=True)
    rasterizer = inria.AbsGaussianRasterizer(settings(inria))
    color, radii, weight = rasterizer(means2D=four, **values)
    (color * weights(color)).sum().backward()
    assert (four.grad[:, 2:] >= four.grad[:, :2].abs() - 1e-3).all()
    assert (four.grad[:, 2:] > four.grad[:, :2].abs() + 0.1).any()
    # The weights are the derivatives by a constant colour.
    ones = torch.zeros(COUNT, 3, requires_grad=True)
    rest = {name: value for name, value in values.items() if name != "shs"}
    draw(inria, {**rest, "colors_precomp": ones}, settings(inria))[0][0].sum().backward()
    assert torch.allclose(weight, ones.grad[:, 0], rtol=1e-4, atol=1e-4) and not weight.requires_grad


def test_taming_is_refused_in_a_sentence(quadsplat, inria, variant):
    with pytest.raises(quadsplat.UsageError, match="taming-3dgs's rasterizer returns 13 values"):
        draw(inria, gaussians(), settings(inria, pixel_weights=torch.zeros(HEIGHT, WIDTH)))
    variant("taming")
    with pytest.raises(quadsplat.UsageError, match="train with the variant 3dgs_accel"):
        draw(inria, gaussians(), settings(inria))


# ---- what is wrong in the replaced modules

def test_the_gradient_of_scales_has_the_factor_of_the_modifier(inria):
    values = gaussians(torch.float64, 6)
    others = {name: value.detach() for name, value in values.items() if name != "scales"}
    check(lambda scales: draw(inria, {**others, "scales": scales},
                              settings(inria, torch.float64, scale_modifier=1.7))[:1], values["scales"])


def test_gradients_of_the_clamped_jacobian_equal_differences(inria):
    values = gaussians(torch.float64, 6)
    with torch.no_grad():  # slopes beyond 1.3 times the field of view
        values["means3D"][:, 0] = torch.linspace(-3.5, 4.5, 6)
        values["scales"][:] = 1.2
    others = {name: value.detach() for name, value in values.items() if name != "means3D"}
    check(lambda means: draw(inria, {**others, "means3D": means}, settings(inria, torch.float64))[:1],
          values["means3D"])


def test_gradients_with_compensation_equal_differences(inria):
    values = gaussians(torch.float64, 5)
    with torch.no_grad():
        values["scales"] *= 0.1
    names = list(values)
    check(lambda *tensors: draw(inria, dict(zip(names, tensors)),
                                settings(inria, torch.float64, antialiasing=True))[0::2],
          *values.values())


def test_inputs_and_gradients_of_any_strides_are_read(inria):
    values = gaussians()
    view = settings(inria, antialiasing=True)
    color, _, inverse = draw(inria, values, view)
    expected = torch.autograd.grad(color.sum() + inverse.sum(), list(values.values()))
    assert inverse.sum().grad_fn is not None  # the gradients of sums are expanded
    turned = {name: value.detach().transpose(0, -1).contiguous().transpose(0, -1).requires_grad_()
              for name, value in values.items()}
    color, _, inverse = draw(inria, turned, view)
    found = torch.autograd.grad((color, inverse), list(turned.values()),
                                [torch.ones_like(color), torch.ones_like(inverse)])
    assert all(torch.equal(a, b) for a, b in zip(found, expected))


def test_other_devices_are_refused_in_a_sentence(quadsplat, inria):
    for name in ("viewmatrix", "projmatrix", "bg", "campos"):
        elsewhere = getattr(settings(inria), name).to("meta")
        with pytest.raises(quadsplat.UsageError, match="is on the device meta"):
            draw(inria, gaussians(), settings(inria, **{name: elsewhere}))
    with pytest.raises(quadsplat.UsageError, match="means is on the device meta"):
        draw(inria, {**gaussians(), "means3D": torch.zeros(COUNT, 3, device="meta")}, settings(inria))


def test_infinite_gaussians_are_not_drawn(inria):
    values = gaussians()
    expected, _ = draw(inria, {name: value[2:] for name, value in values.items()}, settings(inria))
    with torch.no_grad():
        values["means3D"][0, 0] = float("inf")
        values["scales"][1, 1] = float("nan")
    color, radii = draw(inria, values, settings(inria))
    color.sum().backward()
    assert torch.equal(color, expected) and radii[:2].tolist() == [0, 0]
    assert all(value.grad.isfinite().all() and not value.grad[:2].any() for value in values.values())


def test_two_runs_have_the_same_bits(inria):
    def run():
        values = gaussians(count=300)
        color, _ = draw(inria, values, settings(inria))
        return [color, *torch.autograd.grad((color * weights(color)).sum(), list(values.values()))]

    assert all(torch.equal(a, b) for a, b in zip(run(), run()))


def test_no_gaussians_have_gradients_of_their_shapes(inria):
    values = gaussians(count=0)
    color, radii = draw(inria, values, settings(inria))
    assert torch.equal(color[:, 0, 0], torch.tensor([0.1, 0.3, 0.6])) and radii.shape == (0,)
    color.sum().backward()
    assert all(value.grad.shape == value.shape for value in values.values())


def test_empty_tiles_at_the_end_are_drawn(inria):
    values = {name: value[:1] for name, value in gaussians().items()}
    with torch.no_grad():
        values["means3D"][0] = torch.tensor([-0.35, -1.0, 3.0])
        values["scales"][:] = 0.03
    color, radii = draw(inria, values, settings(inria, antialiasing=False))[:2]
    color.sum().backward()
    assert radii[0] > 0 and torch.equal(color[:, -1, -1], torch.tensor([0.1, 0.3, 0.6]))


def test_errors_belong_to_the_call_that_makes_them(quadsplat, inria):
    values = gaussians()
    for change, sentence in [
            ({"scales": None}, "give either scales and rotations or cov3D_precomp"),
            ({"cov3D_precomp": torch.zeros(COUNT, 6)}, "give either scales and rotations or"),
            ({"shs": None}, "give either shs or colors_precomp"),
            ({"colors_precomp": torch.zeros(COUNT, 3)}, "give either shs or colors_precomp"),
            ({"scales": torch.zeros(COUNT, 2)}, "scales"),
            ({"rotations": torch.zeros(3, 4)}, "rotations")]:
        with pytest.raises(Exception) as raised:
            draw(inria, {**values, **change}, settings(inria))
        assert isinstance(raised.value, quadsplat.UsageError) and sentence in str(raised.value)
    for change, sentence in [
            ({"image_width": 0}, "width: 0 pixels are not between 1 and 65535"),
            ({"tanfovx": 0.0}, "projmatrix: is not the view times"),
            ({"tanfovy": float("nan")}, "projmatrix: is not the view times"),
            ({"projmatrix": torch.eye(4)}, "projmatrix: is not the view times"),
            ({"projmatrix": torch.eye(3)}, "projmatrix: has 3 x 3 elements instead of 4 x 4"),
            ({"tanfovx": 2.0}, "projmatrix: is not the view times"),
            ({"scale_modifier": 0.0}, "scale of splats"), ({"sh_degree": 4}, "sh_degree")]:
        with pytest.raises(quadsplat.UsageError) as raised:
            draw(inria, values, settings(inria, **change))
        assert sentence in str(raised.value), change


def test_the_camera_has_gradients(inria):
    values = {name: value.detach() for name, value in gaussians().items()}
    view = settings(inria)
    matrix = view.viewmatrix.clone().requires_grad_()
    place = view.campos.clone().requires_grad_()
    color, _ = draw(inria, values, view._replace(viewmatrix=matrix, campos=place))
    (color * weights(color)).sum().backward()
    assert matrix.grad[:, :3].abs().min(0)[0].max() > 0 and not matrix.grad[:, 3].any()
    assert place.grad.abs().max() > 0


def test_the_turn_and_shift_of_a_pose_equal_differences(inria):
    values = {name: value.detach() for name, value in gaussians(torch.float64, 6).items()}
    raw = projection()

    def results(view, theta=None, rho=None):
        changes = {"viewmatrix": view.T, "projmatrix": view.T @ raw, "projmatrix_raw": raw,
                   "campos": torch.inverse(view)[:3, 3]}
        drawn = draw(inria, values, settings(inria, torch.float64, **changes), theta=theta, rho=rho)
        return sum((picture * weights(picture, seed)).sum()
                   for seed, picture in enumerate((drawn[0], drawn[2], drawn[3])))

    theta, rho = torch.zeros(3, dtype=torch.float64, requires_grad=True), torch.full(
        (3,), 0.4, dtype=torch.float64, requires_grad=True)  # the values are ignored
    results(pose(), theta, rho).backward()
    found = torch.cat([theta.grad, rho.grad])
    for axis in range(6):
        ends = []
        for sign in (1, -1):
            x, y, z, *shift = (sign * 1e-6 * (torch.arange(6) == axis)).double().tolist()
            generator = torch.tensor([[0, -z, y, shift[0]], [z, 0, -x, shift[1]], [-y, x, 0, shift[2]],
                                      [0, 0, 0, 0]], dtype=torch.float64)
            ends.append(results(torch.matrix_exp(generator) @ pose()).item())
        assert found[axis].item() == pytest.approx((ends[0] - ends[1]) / 2e-6, rel=1e-4, abs=1e-3)


# ---- the other modules

def test_fused_ssim_has_gradients_of_both_pictures_and_checks_sizes(quadsplat):
    from quadsplat.torch import ssim

    a = torch.rand(1, 3, 14, 13, dtype=torch.float64, requires_grad=True)
    b = torch.rand(1, 3, 14, 13, dtype=torch.float64, requires_grad=True)
    for padding in ("same", "valid"):
        assert torch.autograd.gradcheck(lambda x, y: ssim(x, y, padding), (a, b), eps=1e-6, atol=1e-7)
    expected = quadsplat.ssim(a.detach().numpy(), b.detach().numpy())
    assert ssim(a, b).item() == expected and ssim(a, a).item() == pytest.approx(1)
    single = torch.rand(2, 3, 20, 15, requires_grad=True)
    ssim(single, single.detach()[:, :, :, :].clone().half().float()).backward()
    assert single.grad.shape == single.shape
    with pytest.raises(quadsplat.UsageError):
        ssim(a, b[:, :, :5])
    with pytest.raises(quadsplat.UsageError, match="padding: 'full' is none of"):
        ssim(a, b, "full")
    with pytest.raises(quadsplat.UsageError, match="ssim: a is on the device meta"):
        ssim(a.detach().to("meta"), b)


def test_relocation_takes_columns_and_tables(inria):
    opacity, scale = torch.full((4, 1), 0.6), torch.full((4, 3), 0.2)
    count = torch.tensor([1, 2, 3, 60], dtype=torch.int32)
    new_opacity, new_scale = inria.compute_relocation(opacity, scale, count, torch.zeros(51, 51), 51)
    assert new_opacity.shape == (4, 1) and new_scale.shape == (4, 3)
    assert torch.allclose(new_opacity[:3, 0], 1 - (1 - torch.tensor(0.6)) ** (1 / count[:3].float()))
    assert torch.allclose(new_scale[0], scale[0]) and (new_scale[1:] < 0.2).all()


def test_sparse_adam_moves_visible_rows_without_correction(quadsplat):
    from quadsplat.torch import SparseAdam

    values = torch.nn.Parameter(torch.ones(3, 2, 4))
    with pytest.raises(quadsplat.UsageError, match="more than one tensor"):
        optimizer = SparseAdam([values, torch.nn.Parameter(torch.ones(3))], lr=0.1, eps=1e-15)
        optimizer.step(torch.ones(3, dtype=torch.bool), 3)
    optimizer = SparseAdam([{"params": [values], "lr": 0.1, "name": "xyz"}], lr=0.0, eps=1e-15)
    visible = torch.tensor([True, False, True])
    squared = (values ** 2).sum()
    values.grad = torch.full_like(values, 2.0)
    optimizer.step(visible, 3)
    move = 0.1 * (0.1 * 2) / math.sqrt(0.001 * 4)
    assert torch.allclose(values[visible], torch.tensor(1 - move))
    assert torch.equal(values[1], torch.ones(2, 4))
    state = optimizer.state[values]
    assert not state["exp_avg"][1].any() and state["exp_avg"][0].max() > 0
    with pytest.raises(RuntimeError, match="modified by an inplace operation"):
        squared.backward()
    assert set(state) == {"step", "exp_avg", "exp_avg_sq"} and float(state["step"]) == 0
