# SPDX-License-Identifier: MIT
"""gsplat's rasterization(): values, shapes, gradients, the rules of versions, refusals."""
import math
import types

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="torch is not installed (python3-torch)")

WIDTH, HEIGHT, COUNT, CAMERAS = 50, 38, 20, 2


@pytest.fixture(scope="module")
def gsplat(quadsplat):
    from quadsplat.dropin import _gsplat

    return _gsplat


@pytest.fixture
def version(monkeypatch):
    import sys

    def choose(number):
        monkeypatch.setitem(sys.modules, "gsplat", types.SimpleNamespace(__version__=number))

    return choose


def scene(dtype=torch.float32, count=COUNT, sh=True):
    draw = torch.Generator().manual_seed(11)

    def of(function, *shape):
        return function(*shape, generator=draw, dtype=torch.float64)

    values = {"means": of(torch.randn, count, 3) * 0.5 + torch.tensor([0, 0, 3.0]),
              "quats": of(torch.randn, count, 4), "scales": of(torch.rand, count, 3) * 0.2 + 0.05,
              "opacities": of(torch.rand, count) * 0.6 + 0.2,
              "colors": of(torch.randn, count, 4, 3) * 0.3 if sh else of(torch.rand, count, 5)}
    if count:
        values["means"][0] = torch.tensor([0, 0, -5.0])  # behind every camera
    return {name: value.to(dtype).requires_grad_() for name, value in values.items()}


def cameras(dtype=torch.float32):
    views = torch.eye(4, dtype=torch.float64).repeat(CAMERAS, 1, 1)
    views[1, 0, 0] = views[1, 2, 2] = np.cos(0.3)
    views[1, 0, 2], views[1, 2, 0] = np.sin(0.3), -np.sin(0.3)
    views[1, :3, 3] = torch.tensor([-0.8, 0.1, 0.3])
    lens = torch.tensor([[44.0, 0, 27], [0, 40, 18], [0, 0, 1]], dtype=torch.float64)
    return {"viewmats": views.to(dtype).requires_grad_(), "Ks": lens.repeat(CAMERAS, 1, 1).to(dtype)}


def draw(gsplat, values, **options):
    dtype = values["means"].dtype
    given = {**values, **cameras(dtype), "width": WIDTH, "height": HEIGHT, **options}
    if values["colors"].dim() == 3 and "sh_degree" not in options:
        given["sh_degree"] = 1
    return gsplat.rasterization(**given)


def weights(tensor, seed=3):
    generator = torch.Generator().manual_seed(seed)
    return torch.rand(tensor.shape, generator=generator, dtype=torch.float64).to(tensor.dtype)


def own(quadsplat, values, number, gsplat, **changes):
    """The same picture by rasterize()."""
    from quadsplat.torch import Rules, rasterize

    given = cameras()
    camera = quadsplat.Camera.from_intrinsics(given["Ks"][number].numpy(), np.eye(4), WIDTH, HEIGHT,
                                              near_depth=0.01)
    rules = {"cull": "exact", "sh_degree": 1, "alpha_max": 0.999, "compensation_floor": 0.0,
             "zero_color_passes": True, "alpha_max_blocks": True, "stops_at_equal": True,
             "slopes": (-27 / 44 - 0.3 * 25 / 44, -18 / 40 - 0.3 * 19 / 40,
                        23 / 44 + 0.3 * 25 / 44, 20 / 40 + 0.3 * 19 / 40)}
    return rasterize(values["means"], values["scales"], values["quats"], values["opacities"],
                     values["colors"], camera=camera, view_from_world=given["viewmats"][number].detach(),
                     outputs=["color", "alpha", "depth"], rules=Rules(**{**rules, **changes}))


def test_pictures_are_those_of_rasterize(quadsplat, gsplat):
    values = scene()
    colors, alphas, info = draw(gsplat, values, render_mode="RGB+D")
    assert colors.shape == (CAMERAS, HEIGHT, WIDTH, 4) and alphas.shape == (CAMERAS, HEIGHT, WIDTH, 1)
    for number in range(CAMERAS):
        expected = own(quadsplat, values, number, gsplat)
        assert torch.allclose(colors[number, ..., :3], expected.color, atol=1e-4)
        assert torch.allclose(colors[number, ..., 3], expected.depth, atol=1e-4)
        assert torch.allclose(alphas[number, ..., 0], expected.alpha, atol=1e-5)
    assert alphas.max() > 0.5


def test_render_modes_are_parts_of_each_other(gsplat):
    values = scene()
    modes = {mode: draw(gsplat, values, render_mode=mode)
             for mode in ("RGB", "D", "ED", "RGB+D", "RGB+ED")}
    color, alpha, _ = modes["RGB"]
    depth = modes["D"][0]
    assert torch.equal(modes["ED"][0], depth / alpha.clamp(min=1e-10))
    assert torch.equal(modes["RGB+D"][0], torch.cat([color, depth], -1))
    assert torch.equal(modes["RGB+ED"][0], torch.cat([color, modes["ED"][0]], -1))
    assert depth.shape == (CAMERAS, HEIGHT, WIDTH, 1)
    assert torch.autograd.grad(depth.sum(), values["means"])[0].abs().max() > 0


def test_backgrounds_are_behind_colours_alone(gsplat):
    values = scene(sh=False)
    behind = torch.rand(CAMERAS, 5, requires_grad=True)
    plain, alphas, _ = draw(gsplat, values, render_mode="RGB+D")
    colors, _, _ = draw(gsplat, values, render_mode="RGB+D", backgrounds=behind)
    expected = plain[..., :5] + (1 - alphas) * behind[:, None, None]
    assert torch.allclose(colors[..., :5], expected, atol=1e-5)
    assert torch.equal(colors[..., 5], plain[..., 5])
    colors.sum().backward()
    assert behind.grad.abs().min() > 0


def test_colours_of_each_camera_and_covariances(gsplat):
    values = scene(sh=False)
    expected, _, _ = draw(gsplat, values)
    each = values["colors"].detach().repeat(CAMERAS, 1, 1).requires_grad_()
    found, _, _ = draw(gsplat, {**values, "colors": each}, sh_degree=None)
    assert torch.equal(found, expected)
    whole, inverse = gsplat.quat_scale_to_covar_preci(values["quats"], values["scales"])
    assert torch.allclose(whole @ inverse, torch.eye(3).expand(COUNT, 3, 3), atol=1e-3)
    six, none = gsplat.quat_scale_to_covar_preci(values["quats"], values["scales"], True, False, True)
    assert none is None and torch.equal(six[:, 1], whole[:, 0, 1]) and six.shape == (COUNT, 6)
    found, _, _ = draw(gsplat, {**values, "quats": None, "scales": None}, covars=whole)
    assert torch.allclose(found, expected, atol=1e-4)
    gradient = torch.autograd.grad(found.sum(), values["scales"])[0]
    assert torch.allclose(gradient, torch.autograd.grad(expected.sum(), values["scales"])[0],
                          rtol=1e-2, atol=1e-2)


@pytest.mark.parametrize("packed", [True, False])
def test_gradients_equal_differences(gsplat, packed):
    values = scene(torch.float64, 6)
    names = list(values)

    def numbers(*tensors):
        colors, alphas, _ = draw(gsplat, dict(zip(names, tensors)), packed=packed, render_mode="RGB+ED",
                                 rasterize_mode="antialiased")
        return torch.stack([(colors * weights(colors, 1)).sum(), (alphas * weights(alphas, 2)).sum()])

    assert torch.autograd.gradcheck(numbers, tuple(values.values()), eps=1e-6, atol=1e-3, rtol=1e-3)


def test_gradients_of_the_camera_equal_differences(gsplat):
    values = {name: value.detach() for name, value in scene(torch.float64, 6).items()}
    given = cameras(torch.float64)

    def numbers(move):
        x, y, z, *shift = move
        none = torch.zeros((), dtype=torch.float64)
        rows = [[none, -z, y, shift[0]], [z, none, -x, shift[1]], [-y, x, none, shift[2]], [none] * 4]
        turned = torch.matrix_exp(torch.stack([torch.stack(row) for row in rows])) @ given["viewmats"].detach()
        colors, _, _ = draw(gsplat, values, viewmats=turned)
        return (colors * weights(colors)).sum()

    start = torch.tensor([0.01, -0.02, 0.01, 0.03, 0.02, -0.02], dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(numbers, (start,), eps=1e-6, atol=1e-3, rtol=1e-3)


# ---- scenes

def batch_of(sh=True, dtype=torch.float32):
    """Scenes of 2 x 3, which differ, with their cameras."""
    alone = []
    for number in range(6):
        values = {name: value.detach().clone() for name, value in scene(dtype, sh=sh).items()}
        values["means"] += 0.05 * number
        values["opacities"] *= 1 - 0.1 * number
        values["colors"] *= 1 + 0.1 * number
        alone.append(values)
    views = cameras(dtype)
    whole = {name: torch.stack([values[name] for values in alone]).reshape(2, 3, *alone[0][name].shape)
             .requires_grad_() for name in alone[0]}
    given = {name: tensor.detach().repeat(2, 3, 1, 1, 1) for name, tensor in views.items()}
    given["viewmats"][1, 2, :, :3, 3] += 0.1
    return alone, whole, given


@pytest.mark.parametrize("packed", [True, False])
@pytest.mark.parametrize("sh", [True, False])
def test_scenes_of_leading_dimensions_are_drawn_as_one_by_one(gsplat, packed, sh):
    alone, whole, given = batch_of(sh=sh)
    behind = torch.rand(2, 3, CAMERAS, 3 if sh else 5)
    options = {"packed": packed, "render_mode": "RGB+ED", "absgrad": True, "sh_degree": 1 if sh else None}
    colors, alphas, info = draw(gsplat, whole, **given, backgrounds=behind, **options)
    channels = 4 if sh else 6
    assert colors.shape == (2, 3, CAMERAS, HEIGHT, WIDTH, channels)
    assert alphas.shape == (2, 3, CAMERAS, HEIGHT, WIDTH, 1)
    assert (info["n_batches"], info["n_cameras"]) == (6, CAMERAS)
    info["means2d"].retain_grad()
    (colors * weights(colors)).sum().backward()
    seen = 0
    for number, values in enumerate(alone):
        values = {name: value.requires_grad_() for name, value in values.items()}
        place = divmod(number, 3)
        one, one_alphas, own = draw(gsplat, values, **{n: t[place] for n, t in given.items()},
                                    backgrounds=behind[place], **options)
        assert torch.equal(colors[place], one) and torch.equal(alphas[place], one_alphas)
        own["means2d"].retain_grad()
        (one * weights(colors)[place]).sum().backward()
        for name, value in values.items():
            assert torch.equal(whole[name].grad[place], value.grad), name
        rows = info["batch_ids"] == number if packed else place
        for name in ("means2d", "depths", "conics", "opacities", "radii"):
            assert torch.equal(info[name][rows], own[name]), name
        assert torch.equal(info["means2d"].grad[rows], own["means2d"].grad)
        assert torch.equal(info["means2d"].absgrad[rows], own["means2d"].absgrad)
        if packed:
            assert torch.equal(info["camera_ids"][rows], own["camera_ids"])
            assert torch.equal(info["gaussian_ids"][rows], own["gaussian_ids"])
            seen += len(own["gaussian_ids"])
    assert not packed or seen == len(info["batch_ids"])


def test_colours_belong_to_all_scenes_or_to_each_camera(gsplat):
    _, whole, given = batch_of()
    shared = scene()["colors"]
    each = shared.detach().expand(2, 3, CAMERAS, *shared.shape)
    expected = draw(gsplat, {**whole, "colors": shared}, **given, sh_degree=1)[0]
    assert torch.equal(draw(gsplat, {**whole, "colors": each}, **given, sh_degree=1)[0], expected)
    by_scene = shared.detach().expand(2, 3, *shared.shape)
    assert torch.equal(draw(gsplat, {**whole, "colors": by_scene}, **given, sh_degree=1)[0], expected)
    expected.sum().backward()
    assert shared.grad.abs().max() > 0


# ---- signals

@pytest.mark.parametrize("sh", [True, False])
def test_signals_are_channels_behind_the_colours(gsplat, sh):
    values = scene(sh=sh)
    signals = torch.randn(COUNT, 4, generator=torch.Generator().manual_seed(2)).requires_grad_()
    behind = torch.rand(CAMERAS, 3 if sh else 5)
    options = {"backgrounds": behind, "render_mode": "RGB+D", "absgrad": True}
    plain, plain_alphas, _ = draw(gsplat, values, **options)
    colors, alphas, info = draw(gsplat, values, extra_signals=signals, **options)
    found = info["render_extra_signals"]
    assert torch.allclose(colors, plain, atol=1e-6) and torch.equal(alphas, plain_alphas)
    assert found.shape == (CAMERAS, HEIGHT, WIDTH, 4)
    alone, _, _ = draw(gsplat, {**values, "colors": signals}, sh_degree=None)
    assert torch.allclose(found, alone, atol=1e-6)
    each = signals.detach().expand(CAMERAS, COUNT, 4)
    assert torch.equal(draw(gsplat, values, extra_signals=each, **options)[2]["render_extra_signals"], found)
    # Both have gradients, as if they were drawn alone.
    names = [*values, "signals"]
    by = [weights(colors, 1), weights(found, 2)]
    together = torch.autograd.grad([colors, found], [*values.values(), signals], by)
    apart = torch.autograd.grad([plain, alone], [*values.values(), signals], by)
    for name, a, b in zip(names, together, apart):
        assert torch.allclose(a, b, rtol=1e-3, atol=1e-3 * b.abs().max()), name
    depth, _, info = draw(gsplat, values, extra_signals=signals, render_mode="ED")
    assert depth.shape[-1] == 1 and torch.allclose(info["render_extra_signals"], alone, atol=1e-6)


def test_gradients_with_signals_equal_differences(gsplat):
    values = scene(torch.float64, 5)
    values["signals"] = torch.rand(5, 2, dtype=torch.float64, requires_grad=True)
    names = list(values)

    def numbers(*tensors):
        given = dict(zip(names, tensors))
        colors, _, info = draw(gsplat, given, extra_signals=given.pop("signals"))
        found = info["render_extra_signals"]
        return torch.stack([(colors * weights(colors, 1)).sum(), (found * weights(found, 2)).sum()])

    assert torch.autograd.gradcheck(numbers, tuple(values.values()), eps=1e-6, atol=1e-3, rtol=1e-3)


# ---- info

def test_info_is_packed_or_has_a_row_of_every_camera(gsplat):
    values = scene()
    _, _, packed = draw(gsplat, values)
    _, _, whole = draw(gsplat, values, packed=False)
    assert whole["camera_ids"] is None and whole["gaussian_ids"] is None
    cameras_of, gaussians_of = packed["camera_ids"], packed["gaussian_ids"]
    assert cameras_of.dtype == gaussians_of.dtype == torch.int64
    for name in ("means2d", "depths", "conics", "opacities", "radii"):
        assert whole[name].shape[:2] == (CAMERAS, COUNT)
        assert torch.equal(packed[name], whole[name][cameras_of, gaussians_of]), name
        assert not whole[name][:, 0].any(), name  # the culled row is 0
    assert 0 not in gaussians_of and len(gaussians_of) > COUNT
    assert (packed["width"], packed["height"], packed["n_cameras"]) == (WIDTH, HEIGHT, CAMERAS)
    assert (packed["tile_width"], packed["tile_height"], packed["tile_size"]) == (4, 3, 16)
    with pytest.raises(KeyError, match="info has no 'isect_ids': the lists of tiles are in"):
        packed["isect_ids"]
    # gsplat's pixels have their centres at halves.
    mean = values["means"][gaussians_of[0]]
    assert packed["means2d"][0].tolist() == pytest.approx(
        [44 * float(mean[0] / mean[2]) + 27, 40 * float(mean[1] / mean[2]) + 18], abs=1e-3)


class Consumer:
    """Sums what densification reads, as the usual strategy does, in our own words."""

    def __init__(self, absolute):
        self.absolute = absolute
        self.moved, self.seen = torch.zeros(COUNT), torch.zeros(COUNT)

    def before(self, info):
        info["means2d"].retain_grad()

    def after(self, info, packed):
        points = info["means2d"]
        by = (points.absgrad if self.absolute else points.grad).clone()
        by[..., 0] *= info["width"] / 2 * info["n_cameras"]
        by[..., 1] *= info["height"] / 2 * info["n_cameras"]
        if packed:
            ids, rows = info["gaussian_ids"], by
        else:
            visible = (info["radii"] > 0).all(-1) if info["radii"].dim() == 3 else info["radii"] > 0
            ids, rows = torch.where(visible)[1], by[visible]
        self.moved.index_add_(0, ids, rows.norm(dim=-1))
        self.seen.index_add_(0, ids, torch.ones(len(ids)))


@pytest.mark.parametrize("number", ["1.4.0", "1.5.3", "1.6.0"])
@pytest.mark.parametrize("absolute", [False, True])
def test_a_strategy_reads_gradients_of_centres_in_pixels(gsplat, version, absolute, number):
    version(number)
    sums = []
    for packed in (True, False):
        values, consumer = scene(), Consumer(absolute)
        for _ in range(2):
            colors, _, info = draw(gsplat, values, packed=packed, absgrad=absolute)
            consumer.before(info)
            (colors * weights(colors)).sum().backward()
            consumer.after(info, packed)
        sums.append((consumer.moved, consumer.seen))
    assert torch.allclose(sums[0][0], sums[1][0], rtol=1e-4) and torch.equal(sums[0][1], sums[1][1])
    assert sums[0][0][0] == 0 and (sums[0][0] > 0).sum() >= COUNT - 5


class Plain:
    """Our own words as gsplat's DefaultStrategy has them."""

    key_for_gradient = "means2d"

    def __init__(self, absolute):
        self.absgrad, self.calls = absolute, 0

    def _update_state(self, _, state, info, packed=False):
        self.calls += 1
        consumer = Consumer(self.absgrad)
        consumer.moved, consumer.seen = (
            torch.zeros(COUNT) if state[name] is None else state[name] for name in ("grad2d", "count"))
        consumer.after(info, packed)
        state.update(grad2d=consumer.moved, count=consumer.seen)


@pytest.mark.parametrize("number, packed, of_cameras, with_radii, is_quick", [
    ("1.6.0", False, 1, False, True), ("1.5.3", False, 1, False, True), ("1.4.0", False, 1, False, False),
    ("1.6.0", True, 1, False, False), ("1.6.0", False, 2, False, False), ("1.6.0", False, 1, True, False)])
@pytest.mark.parametrize("absolute", [False, True])
def test_the_state_of_the_usual_strategy_is_the_state_of_gsplats_method(
        gsplat, version, absolute, number, packed, of_cameras, with_radii, is_quick):
    from quadsplat.dropin import _gsplat_strategy

    version(number)
    quick, plain = Plain(absolute), Plain(absolute)
    update = _gsplat_strategy._update_state(Plain._update_state)
    states = [{"grad2d": None, "count": None, **({"radii": None} if with_radii else {})} for _ in range(2)]
    for place in range(3):
        values, given = scene(), cameras()
        values["means"].data[1:5, 0] += place  # other Gaussians leave the picture
        given = {name: tensor.detach()[:of_cameras] for name, tensor in given.items()}
        colors, _, info = draw(gsplat, values, packed=packed, absgrad=absolute, **given)
        info["means2d"].retain_grad()
        (colors * weights(colors)).sum().backward()
        plain._update_state(None, states[0], info, packed=packed)
        update(quick, None, states[1], info, packed=packed)
    assert torch.allclose(states[0]["grad2d"], states[1]["grad2d"], rtol=1e-6) and torch.equal(states[0]["count"], states[1]["count"])
    assert states[0]["grad2d"].max() > 0 and 0 < states[0]["count"].sum() < 3 * of_cameras * COUNT
    assert quick.calls == (0 if is_quick else 3)


def test_absolute_sums_are_not_below_the_gradient(gsplat):
    colors, _, info = draw(gsplat, scene(), absgrad=True)
    info["means2d"].retain_grad()
    (colors * weights(colors)).sum().backward()
    assert (info["means2d"].absgrad >= info["means2d"].grad.abs() - 1e-3).all()
    assert (info["means2d"].absgrad > info["means2d"].grad.abs() + 0.1).any()


def test_runs_have_the_same_bits_also_of_the_cameras(gsplat):
    def run():
        values = scene(count=200)
        given = cameras()
        colors, alphas, _ = draw(gsplat, values, **given)
        loss = (colors * weights(colors)).sum() + (alphas * weights(alphas)).sum()
        return torch.autograd.grad(loss, [*values.values(), given["viewmats"]])

    assert all(torch.equal(a, b) for a, b in zip(run(), run()))


def test_sparse_gradients_have_the_rows_of_visible_gaussians(gsplat):
    values = scene()
    loss = draw(gsplat, values)[0].sum()
    dense = torch.autograd.grad(loss, [values["means"], values["quats"], values["scales"]])
    colors, _, info = draw(gsplat, values, sparse_grad=True)
    colors.sum().backward()
    for name, expected in zip(("means", "quats", "scales"), dense):
        gradient = values[name].grad
        assert gradient.is_sparse and torch.equal(gradient.to_dense(), expected)
        assert gradient.coalesce().indices()[0].tolist() == sorted(set(info["gaussian_ids"].tolist()))
    assert not values["opacities"].grad.is_sparse


# ---- versions

def test_radii_have_the_shape_and_formula_of_the_version(gsplat, version):
    values = scene()
    with torch.no_grad():
        values["opacities"][1], values["opacities"][2] = 1 / 300, 0.02
    found = {}
    for number in ("1.4.0", "1.5.3", "1.6.0", "1.7.0+cu12"):
        version(number)
        info = draw(gsplat, values, packed=False)[2]
        assert info["radii"].dtype == torch.int32
        assert ("n_batches" in info) == (number != "1.4.0")
        found[number] = info["radii"]
    assert found["1.4.0"].shape == (CAMERAS, COUNT)
    assert found["1.5.3"].shape == (CAMERAS, COUNT, 2)
    assert torch.equal(found["1.5.3"], found["1.6.0"]) and torch.equal(found["1.6.0"], found["1.7.0+cu12"])
    assert not found["1.5.3"][:, 1].any() and found["1.4.0"][0, 1] > 0
    assert (found["1.5.3"][0, 2] < found["1.4.0"][0, 2]).all()


@pytest.mark.parametrize("name, mode, alpha_max, has_batches", [
    ("1.4.0rc2", "3dgs", 0.999, False), ("1.5.0rc1", "adr", 0.999, False), ("1.5.3.post1", "adr", 0.999, True),
    ("1.6.0rc1", "adr", 0.99, True), ("1.6.0.dev3+cu12", "adr", 0.99, True), ("1.6b1", "adr", 0.99, True),
    ("2", "adr", 0.99, True), ("unknown", "adr", 0.999, True)])
def test_a_pre_release_has_the_rules_of_its_version(gsplat, version, name, mode, alpha_max, has_batches):
    version(name)
    rules = gsplat._version()
    assert (rules.mode, rules.alpha_max, rules.has_batches) == (mode, alpha_max, has_batches)
    assert (rules.least_opacity > 0) == (alpha_max == 0.99)


def test_the_largest_alpha_is_that_of_the_version(gsplat, version):
    values = {name: value[1:2].detach() for name, value in scene(sh=False).items()}
    values.update(means=torch.tensor([[0.0, 0, 2]]), scales=torch.full((1, 3), 2.0),
                  opacities=torch.ones(1).requires_grad_())
    for number, largest in (("1.4.0", 0.999), ("1.5.3", 0.999), ("1.6.0", 0.99)):
        version(number)
        alphas = draw(gsplat, values)[1]
        assert alphas.max().item() == pytest.approx(largest, abs=1e-6)
        gradient = torch.autograd.grad(alphas.max(), values["opacities"])[0]
        assert gradient.item() == 0  # a clamped alpha has none


def test_planes_and_clips_leave_gaussians_out(gsplat):
    values = scene()
    usual = draw(gsplat, values, packed=False)[2]["radii"]
    near = draw(gsplat, values, packed=False, near_plane=3.0)[2]
    assert (near["radii"] > 0).sum() < (usual > 0).sum()
    assert (near["depths"][(near["radii"] > 0).all(-1)] > 3).all()
    far = draw(gsplat, values, packed=False, far_plane=3.0)[2]
    assert (far["depths"][(far["radii"] > 0).all(-1)] <= 3).all()
    clipped = draw(gsplat, values, packed=False, radius_clip=6.0)[2]
    assert 0 < (clipped["radii"] > 0).sum() < (usual > 0).sum()


# ---- the edges

def test_no_gaussians_are_drawn(gsplat):
    values = scene(count=0)
    for packed in (True, False):
        colors, alphas, info = draw(gsplat, values, packed=packed, render_mode="RGB+ED", absgrad=True,
                                    backgrounds=torch.ones(CAMERAS, 3))
        assert torch.equal(colors[..., :3], torch.ones(CAMERAS, HEIGHT, WIDTH, 3)) and not alphas.any()
        colors.sum().backward()
        assert values["means"].grad.shape == (0, 3)


@pytest.mark.parametrize("change, sentence", [
    ({"camera_model": "fisheye"}, "camera_model: 'fisheye' is not drawn, only 'pinhole'"),
    ({"distributed": True}, "distributed: one process draws: leave it off"),
    ({"segmented": True}, "segmented"), ({"tile_size": 8}, "tile_size: 8 is not 16"),
    ({"render_mode": "N"}, "render_mode: 'N' is none of RGB, D, ED, RGB+D, RGB+ED"),
    ({"rasterize_mode": "fast"}, "rasterize_mode: 'fast' is neither"),
    ({"with_ut": True}, "with_ut is not supported"), ({"with_eval3d": True}, "with_eval3d"),
    ({"radial_coeffs": torch.zeros(2, 6)}, "radial_coeffs is not supported"),
    ({"global_z_order": False}, "global_z_order is not supported: leave it on"),
    ({"return_normals": True}, "return_normals is not supported: pass the normals as extra_signals"),
    ({"extra_signals_sh_degree": 3}, "extra_signals_sh_degree is not supported: evaluate the SH"),
    ({"extra_signals": torch.zeros(3)}, "extra_signals has the shape (3,) instead of (20, any)"),
    ({"extra_signals": torch.zeros(COUNT, 30)}, "33 channels are not between 1 and 32"),
    ({"sparse_grad": True, "packed": False}, "sparse_grad needs packed=True"),
    ({"means": torch.zeros(2, COUNT, 3)}, "opacities has the shape (20,) instead of (2, 20)"),
    ({"means": torch.zeros(0, COUNT, 3)}, "means has no scene"), ({"means": torch.zeros(3)}, "means has 1 dimensions"),
    ({"sh_degree": 4}, "sh_degree: 4 is not between 0 and 3"), ({"sh_degree": 2}, "4 coefficients are too few"),
    ({"viewmats": torch.zeros(0, 4, 4)}, "viewmats has no camera"),
    ({"viewmats": torch.zeros(2, 4, 4)}, "viewmats has the last row [0.0, 0.0, 0.0, 0.0] instead of 0, 0, 0, 1"),
    ({"Ks": torch.ones(2, 3, 3)}, "Ks has a skew"), ({"width": 0}, "width: 0 is not between"),
    ({"opacities": torch.zeros(COUNT, 1)}, "opacities has the shape (20, 1) instead of (20)"),
    ({"colors": torch.zeros(COUNT, 33), "sh_degree": None}, "33 channels are not between 1 and 32"),
    ({"quats": None}, "quats is a NoneType instead of a torch.Tensor"),
    ({"means": torch.zeros(COUNT, 3, device="meta")}, "means is on the device meta")])
def test_unsupported_arguments_are_refused_in_a_sentence(quadsplat, gsplat, change, sentence):
    values = {name: value.detach() for name, value in scene().items()}
    with pytest.raises(quadsplat.UsageError) as raised:
        draw(gsplat, **{"values": {**values, **{k: v for k, v in change.items() if k in values}}},
             **{k: v for k, v in change.items() if k not in values})
    assert sentence in str(raised.value)


def test_defaults_of_newer_versions_are_taken(gsplat):
    values = scene()
    expected = draw(gsplat, values)[0]
    found = draw(gsplat, values, global_z_order=True, extra_signals=None, with_ut=False, tile_size=16,
                 rolling_shutter=types.SimpleNamespace(name="GLOBAL"))[0]
    assert torch.equal(found, expected)


def test_functions_of_the_extension(gsplat):
    param, moments = torch.ones(4, 3), [torch.zeros(4, 3), torch.zeros(4, 3)]
    gsplat.adam(param, torch.ones(4, 3), *moments, torch.tensor([True, False, True, True]), 0.1, 0.9,
                0.999, 1e-15)
    assert torch.equal(param[1], torch.ones(3)) and (param[0] < 0.8).all()
    new_opacity, new_scale = gsplat.compute_relocation(
        torch.full((3,), 0.5), torch.full((3, 3), 0.1), torch.tensor([1, 2, 3]), torch.zeros(51, 51))
    assert new_opacity.tolist() == pytest.approx([0.5, 1 - 0.5 ** 0.5, 1 - 0.5 ** (1 / 3)])


def test_relocated_gaussians_have_the_least_opacity_of_the_version(gsplat, version):
    """gsplat 1.6 clamps the opacity of the copies before equation 9 of arXiv 2404.09591."""
    version("1.6.0")
    opacities = torch.tensor([0.5, 0.001, 0.001, 0.006, 1.0], dtype=torch.float64)
    counts, scales = torch.tensor([2, 1, 3, 51, 4]), torch.ones(5, 3, dtype=torch.float64)

    def expected(opacity, count, least):
        shared = min(max(1 - (1 - opacity) ** (1 / count), least), 1 - 2.0 ** -23)
        whole = sum(math.comb(i, k) * (-1) ** k * shared ** (k + 1) / math.sqrt(k + 1)
                    for i in range(count) for k in range(i + 1))
        return shared, opacity / whole

    for given, least in (({}, 0.005), ({"min_opacity": 0.1}, 0.1)):
        new_opacities, new_scales = gsplat.compute_relocation(opacities, scales, counts, torch.zeros(51, 51), **given)
        for row, (opacity, count) in enumerate(zip(opacities.tolist(), counts.tolist())):
            assert (new_opacities[row].item(), new_scales[row, 0].item()) == pytest.approx(expected(opacity, count, least))
    free, _ = gsplat.compute_relocation(opacities, scales, counts, min_opacity=0)
    assert free[1].item() == pytest.approx(0.001) and free[4].item() == 1


class OnePicture:
    """A call of one camera with a loss, by the usual way, or by the general one, for which the camera has a gradient."""

    def __init__(self, gsplat, general, change, added=None, dtype=torch.float32, sh=True):
        self.values = scene(dtype, sh=sh)
        for name in ("means", "opacities"):  # not all are leaves of a trainer's graph
            self.values[name].requires_grad_()
        given = {name: tensor[1:2].detach() for name, tensor in cameras(dtype).items()}
        given["viewmats"].requires_grad_(general)
        self.colors, self.alphas, self.info = draw(gsplat, self.values, **{**given, **change})
        self.info["means2d"].retain_grad()
        loss = (self.colors * weights(self.colors, 1)).sum() + (self.alphas * weights(self.alphas, 2)).sum()
        if added is not None:
            loss = loss + added(self.info)
        loss.backward()

    def results(self):
        points = self.info["means2d"]
        found = {"colors": self.colors, "alphas": self.alphas, "points.grad": points.grad}
        found.update({f"{name}.grad": value.grad for name, value in self.values.items()})
        found.update({name: value for name, value in self.info.items() if isinstance(value, torch.Tensor)})
        if hasattr(points, "absgrad"):
            found["absgrad"] = points.absgrad
        return found


ADDED = {"nothing": None, "centres": lambda info: (info["means2d"] ** 2).sum(),
         "others": lambda info: info["depths"].sum() + (info["conics"] ** 2).sum() + info["opacities"].sum()}


@pytest.mark.parametrize("packed", [True, False])
@pytest.mark.parametrize("added", ADDED)
@pytest.mark.parametrize("change", [
    {}, {"render_mode": "RGB+ED", "rasterize_mode": "antialiased"}, {"absgrad": True, "render_mode": "RGB+D"},
    {"backgrounds": torch.tensor([[0.2, 0.5, 0.9]])}, {"sh_degree": 0}])
def test_the_usual_call_has_the_results_of_the_general_one(gsplat, packed, added, change):
    found, expected = (OnePicture(gsplat, general, {**change, "packed": packed}, ADDED[added]) for general in (False, True))
    assert list(found.info) and set(found.info) == set(expected.info)
    ours, theirs = found.results(), expected.results()
    assert set(ours) == set(theirs)
    for name, value in theirs.items():
        assert ours[name].shape == value.shape and ours[name].dtype == value.dtype, name
        assert torch.allclose(ours[name], value, rtol=1e-4, atol=1e-4 * float(value.abs().max().clamp(min=1e-6))), name
    assert float(theirs["means.grad"].abs().max()) > 0


def test_the_usual_call_draws_channels(gsplat):
    found, expected = (OnePicture(gsplat, general, {"sh_degree": None}, sh=False).results() for general in (False, True))
    assert all(torch.allclose(found[name], expected[name], rtol=1e-4, atol=1e-4) for name in expected)


@pytest.mark.parametrize("packed", [True, False])
def test_gradients_of_the_usual_call_equal_differences(gsplat, packed):
    values = scene(torch.float64, 6)
    given = {name: tensor[:1].detach() for name, tensor in cameras(torch.float64).items()}

    def numbers(*tensors):
        colors, alphas, info = draw(gsplat, dict(zip(values, tensors)), packed=packed, **given)
        return torch.stack([(colors * weights(colors, 1)).sum(), (alphas * weights(alphas, 2)).sum(),
                            info["means2d"].sum()])

    assert torch.autograd.gradcheck(numbers, tuple(values.values()), eps=1e-6, atol=1e-3, rtol=1e-3)


def test_hooks_and_retained_graphs_of_the_usual_call(gsplat):
    values, given = scene(), {name: tensor[:1].detach() for name, tensor in cameras().items()}
    colors, _, info = draw(gsplat, values, packed=False, **given)
    loss = (colors * weights(colors)).sum()
    loss.backward(retain_graph=True)
    once = values["means"].grad.clone()
    handle = info["means2d"].register_hook(lambda by: 3 * by)  # passes two more through the centres
    loss.backward()
    handle.remove()
    assert not torch.allclose(values["means"].grad, 2 * once, rtol=1e-3)
    general = OnePicture(gsplat, False, {"packed": False}).values["means"].grad
    assert general.isfinite().all()
    colors, _, info = draw(gsplat, values, packed=False, **given)
    info["means2d"].register_hook(lambda by: by.mul_(2))
    with pytest.raises(RuntimeError, match="changed in place"):
        (colors * weights(colors)).sum().backward()


@pytest.mark.parametrize("read", [lambda info: info["conics"], lambda info: info.get("conics"), lambda info: dict(info)["conics"],
                                  lambda info: {**info}["conics"], lambda info: info.copy()["conics"],
                                  lambda info: dict(info.items())["conics"], lambda info: info.pop("conics"),
                                  lambda info: dict(zip(info, info.values()))["conics"]])
def test_info_gives_values_that_are_computed_when_they_are_read(gsplat, read):
    given = {name: tensor[:1].detach() for name, tensor in cameras().items()}
    _, _, info = draw(gsplat, scene(), packed=False, **given)
    assert read(info).shape == (1, COUNT, 3)
    assert "conics" in draw(gsplat, scene(), packed=False, **given)[2] and info.get("nothing", 5) == 5


def test_gaussians_of_any_radius_are_visible(gsplat):
    """The product of two radii may have more than 32 bits."""
    given = {name: tensor[:1].detach() for name, tensor in cameras().items()}
    values = {name: value.detach() for name, value in scene(count=3).items()}
    values["means"] = torch.tensor([[0, 0, 3.0]] * 3)
    values["scales"] = torch.tensor([[1e3] * 3, [1e4] * 3, [1e5] * 3])
    info = draw(gsplat, values, packed=True, **given)[2]
    assert info["gaussian_ids"].tolist() == [0, 1, 2] and int(info["radii"].max()) > 2 ** 17
