# SPDX-License-Identifier: MIT
"""rasterize() and the drop-ins with tensors on a GPU, against the same tensors on the CPU.

It is written with unittest, because scripts/check_gpu_library runs it on machines that may lack pytest.
"""
import gc
import importlib
import math
import sys
import threading
import unittest
from pathlib import Path

try:
    import torch
except ImportError:
    raise unittest.SkipTest("torch is not installed (python3-torch)") from None
if not torch.cuda.is_available():
    raise unittest.SkipTest("torch sees no GPU")

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "python"))

import quadsplat  # noqa: E402
from quadsplat.torch import Rules, SparseAdam, rasterize, ssim, ssim_and_l1  # noqa: E402
from quadsplat.torch._parts import Step, adam, add_noise  # noqa: E402

COUNT = 300
WIDTH, HEIGHT = 70, 50
PICTURES = ("color", "alpha", "depth", "inverse_depth")
GPU = torch.device("cuda", 0)


def camera():
    matrix = torch.eye(4, dtype=torch.float64)
    angle = 0.3
    matrix[0, 0] = matrix[2, 2] = math.cos(angle)
    matrix[0, 2], matrix[2, 0] = math.sin(angle), -math.sin(angle)
    matrix[:3, 3] = torch.tensor([-0.8, 0.1, 0.2])
    return quadsplat.Camera(WIDTH, HEIGHT, (63, 66), (WIDTH / 2 + 1.5, HEIGHT / 2 - 2), matrix.numpy())


def gaussians(device, count=COUNT, coefficients=9):
    draw = torch.Generator().manual_seed(3)
    values = {"means": torch.randn(count, 3, generator=draw) * 0.5 + torch.tensor([0, 0, 3.0]),
              "scales": torch.rand(count, 3, generator=draw) * 0.2 + 0.02,
              "rotations": torch.randn(count, 4, generator=draw),
              "opacities": torch.rand(count, generator=draw) * 0.7 + 0.2,
              "sh": torch.randn(count, coefficients, 3, generator=draw) * 0.3}
    return {name: value.to(device).requires_grad_() for name, value in values.items()}


def loss_of(pictures):
    """A smooth number of pictures."""
    loss = 0
    for seed, picture in enumerate(pictures):
        if picture is not None:
            weights = torch.rand(picture.shape, generator=torch.Generator().manual_seed(seed))
            loss = loss + (picture * weights.to(picture)).sum() + (picture ** 2).sum()
    return loss


class SceneTest(unittest.TestCase):
    """Scenes and pictures of tensors on the GPU."""

    def setUp(self):
        self.values = {name: value.detach() for name, value in gaussians(GPU).items()}
        self.context = quadsplat.Context("cuda", device=0)
        host = {name: value.cpu() for name, value in self.values.items()}
        self.scene = quadsplat.Scene.from_arrays(**host, context=self.context)

    def test_a_scene_of_tensors_on_the_gpu_draws_the_same(self):
        mixed = dict(self.values, opacities=self.values["opacities"][:, None].clone().requires_grad_(),
                     means=self.values["means"].double(), sh=self.values["sh"].flip(0).flip(0).transpose(0, 1).contiguous().transpose(0, 1))
        for context in (self.context, None):
            scene = quadsplat.Scene.from_arrays(**mixed, context=context)
            self.assertTrue((quadsplat.render(scene, camera()).color == quadsplat.render(self.scene, camera()).color).all())

    def test_tensors_of_another_stream_are_read_when_they_are_ready(self):
        stream = torch.cuda.Stream()
        with torch.cuda.stream(stream):
            late = {name: torch.zeros_like(value) for name, value in self.values.items()}
            torch.cuda._sleep(50_000_000)
            for name, value in late.items():
                value.copy_(self.values[name])
            scene = quadsplat.Scene.from_arrays(**late, context=self.context)
        self.assertTrue((quadsplat.render(scene, camera()).color == quadsplat.render(self.scene, camera()).color).all())

    def test_pictures_are_written_into_tensors_on_the_gpu(self):
        names = ["color", "alpha", "depth", "median_depth"]
        expected = quadsplat.render(self.scene, camera(), outputs=names)
        stream = torch.cuda.Stream()
        with torch.cuda.stream(stream):
            out = {"color": torch.zeros(3, HEIGHT, WIDTH, device=GPU).permute(1, 2, 0),
                   **{name: torch.zeros(HEIGHT, WIDTH, device=GPU) for name in names[1:]}}
            torch.cuda._sleep(50_000_000)
            out["color"].fill_(7)  # enqueued before the picture
            found = quadsplat.render(self.scene, camera(), out=out)
            for name in names:
                self.assertIs(getattr(found, name), out[name])
                self.assertTrue((out[name].cpu().numpy() == getattr(expected, name)).all(), name)
        bytes_of = torch.zeros(HEIGHT, WIDTH, 3, dtype=torch.uint8, device=GPU)
        quadsplat.render(self.scene, camera(), out={"color": bytes_of})
        self.assertTrue((bytes_of.cpu().numpy() == quadsplat.render(self.scene, camera(), dtype="uint8").color).all())

    def test_wrong_places_get_a_sentence(self):
        with self.assertRaisesRegex(quadsplat.UsageError, "alpha: is in host memory, but color is in the memory of GPU 0"):
            quadsplat.render(self.scene, camera(), outputs=["color", "alpha"],
                             out={"color": torch.zeros(HEIGHT, WIDTH, 3, device=GPU)})
        with self.assertRaisesRegex(quadsplat.UsageError, "picture: .* GPU|is in the memory of a GPU"):
            quadsplat.render(self.scene, camera(), out={"color": torch.zeros(HEIGHT, WIDTH, 3, device=GPU)}).psnr(
                torch.zeros(HEIGHT, WIDTH, 3))


class CudaTest(unittest.TestCase):
    def close(self, values, expected, tolerance=1e-3, name=""):
        """Values on the GPU are those of the CPU within rounding."""
        self.assertEqual(values.device.type, "cuda", name)
        self.assertEqual(values.dtype, expected.dtype, name)
        values, expected = values.detach().double().cpu(), expected.detach().double()
        self.assertEqual(values.shape, expected.shape, name)
        reach = max(float(expected.abs().max()), 1e-6) if expected.numel() else 1
        # A pixel of few may decide otherwise at a threshold.
        beyond = (values - expected).abs() > tolerance * reach
        self.assertLessEqual(int(beyond.sum()), beyond.numel() // 500,
                             f"{name}: off by up to {float((values - expected).abs().max())} of {reach}")

    def drawn(self, values, **options):
        options.setdefault("outputs", PICTURES)
        return rasterize(**values, camera=camera(), **options)

    def compare(self, change=lambda values: values, **options):
        """Draws on both devices and compares pictures, radii and gradients."""
        results = []
        for device in ("cpu", GPU):
            values = change(gaussians(device))
            own = {name: value.to(device) if isinstance(value, torch.Tensor) else value
                   for name, value in options.items()}
            drawn = self.drawn(values, **own)
            leaves = [value for value in values.values() if value is not None]
            results.append((drawn, torch.autograd.grad(loss_of(drawn[:4]), leaves)))
        (expected, by), (drawn, gradients) = results
        for name, picture, wanted in zip(PICTURES, drawn, expected):
            self.close(picture, wanted, 1e-4, name)
        self.assertTrue(torch.equal(drawn.radii.cpu(), expected.radii))
        for number, (gradient, wanted) in enumerate(zip(gradients, by)):
            self.close(gradient, wanted, name=f"gradient {number}")
            self.assertGreater(float(gradient.abs().max()), 0)


class Pictures(CudaTest):
    def test_pictures_and_gradients_are_those_of_the_cpu(self):
        self.compare()
        self.compare(background=torch.tensor([0.2, 0.5, 0.9]), rules=Rules(cull="3dgs", antialiased=True))
        self.compare(planar=True, rules=Rules(alpha_max=0.9, alpha_max_blocks=True, stops_at_equal=True))

    def test_colour_alone(self):
        self.assertIsNone(self.drawn(gaussians(GPU), outputs="color").alpha)
        results = []
        for device in ("cpu", GPU):
            values = gaussians(device)
            color = self.drawn(values, outputs="color").color
            results.append([color, *torch.autograd.grad(loss_of([color]), list(values.values()))])
        for value, expected in zip(results[1], results[0]):
            self.close(value, expected)

    def test_channels_covariances_and_halves_of_sh(self):
        def channels(values):
            draw = torch.Generator().manual_seed(5)
            more = torch.rand(COUNT, 5, generator=draw).to(values["means"]).requires_grad_()
            return {**values, "sh": None, "channels": more}

        def covariances(values):
            factor = values["scales"].detach()
            made = torch.zeros(COUNT, 6, device=factor.device)
            made[:, 0], made[:, 3], made[:, 5] = factor[:, 0] ** 2, factor[:, 1] ** 2, factor[:, 2] ** 2
            made[:, 1] = 0.3 * factor[:, 0] * factor[:, 1]
            return {**values, "scales": None, "rotations": None, "covariances": made.requires_grad_()}

        def halves(values):
            sh = values["sh"].detach()
            return {**values, "sh": sh[:, :1].clone().requires_grad_(),
                    "sh_rest": sh[:, 1:].clone().requires_grad_()}

        for change in (channels, covariances, halves):
            self.compare(change)

    def test_strides_and_half_precision(self):
        def strided(values):
            spread = values["means"].detach().repeat_interleave(2, 1)[:, ::2]
            turned = values["sh"].detach().permute(2, 1, 0).contiguous().permute(2, 1, 0)
            return {**values, "means": spread.requires_grad_(), "sh": turned.requires_grad_()}

        self.compare(strided)
        values = gaussians(GPU)
        half = {name: value.detach().half() for name, value in values.items()}
        exact = {name: value.float() for name, value in half.items()}
        self.assertTrue(torch.equal(self.drawn(half).color, self.drawn(exact).color))

    def test_gradients_that_are_expanded(self):
        values = gaussians(GPU)
        self.drawn(values).color.sum().backward()
        other = gaussians(GPU)
        self.drawn(other).color.backward(torch.ones(HEIGHT, WIDTH, 3, device=GPU))
        for name, value in values.items():
            self.assertTrue(torch.equal(value.grad, other[name].grad), name)

    def test_counts_of_pixels_are_those_of_the_cpu(self):
        for options in ({"counts_above": 0.5}, {"counts_above": 0},
                        {"counts_above": 0.5, "boundary": True, "outputs": "alpha"}):
            counts = []
            for device in ("cpu", GPU):
                values = gaussians(device)
                drawn = self.drawn(values, **options)
                self.assertEqual((drawn.pixels.device, drawn.pixels.dtype),
                                 (values["means"].device, torch.int32))
                counts.append(drawn.pixels.cpu())
                loss_of(drawn[:4]).backward()
                self.assertGreater(float(values["means"].grad.abs().max()), 0)
            self.assertTrue(torch.equal(*counts))
            self.assertGreater(int(counts[0].max()), 10)

    def test_no_gaussians(self):
        values = {name: value.detach()[:0].requires_grad_() for name, value in gaussians(GPU).items()}
        background = torch.tensor([0.2, 0.5, 0.9], device=GPU, requires_grad=True)
        drawn = self.drawn(values, background=background)
        self.assertTrue(torch.equal(drawn.color[3, 4], background))
        drawn.color.sum().backward()
        self.assertTrue(torch.allclose(background.grad, torch.full((3,), float(WIDTH * HEIGHT), device=GPU)))
        self.assertEqual(values["means"].grad.shape, (0, 3))

    def test_values_that_are_not_finite_are_not_drawn(self):
        values = gaussians(GPU)
        with torch.no_grad():
            values["means"][0, 1] = float("nan")
            values["scales"][1, 2] = float("inf")
            values["sh"][2, 0, 0] = float("nan")
        drawn = self.drawn(values)
        self.assertTrue(torch.isfinite(drawn.color).all())
        for gradient in torch.autograd.grad(loss_of(drawn[:4]), list(values.values())):
            self.assertFalse(gradient[:3].any())
            self.assertTrue(torch.isfinite(gradient).all())

    def test_equal_bits_twice_and_in_lossless_modes(self):
        def run(**options):
            values = gaussians(GPU)
            drawn = self.drawn(values, **options)
            return [*drawn[:4], *torch.autograd.grad(loss_of(drawn[:4]), list(values.values()))]

        expected = run()
        modes = [mode.name for mode in quadsplat.modes()
                 if mode.is_lossless and not mode.keeps_faint and mode.name != "reference"]
        for mode in [None, *modes]:
            found = run(**({} if mode is None else {"rules": Rules(cull=mode)}))
            self.assertTrue(all(torch.equal(a, b) for a, b in zip(found, expected)), mode)


class Graph(CudaTest):
    def test_the_pose_has_gradients(self):
        results = []
        for device, of_pose in (("cpu", "cpu"), (GPU, GPU), (GPU, "cpu")):
            values = {name: value.detach() for name, value in gaussians(device).items()}
            view = torch.tensor(camera().view_from_world, dtype=torch.float32, device=of_pose,
                                requires_grad=True)
            place = torch.tensor([0.3, -0.4, 0.1], device=of_pose, requires_grad=True)
            first = torch.autograd.grad(loss_of(self.drawn(values, view_from_world=view)[:4]), view)
            both = torch.autograd.grad(
                loss_of(self.drawn(values, view_from_world=view, position=place)[:4]), (view, place))
            results.append([*first, *both])
        for value, expected in zip(results[1], results[0]):
            self.close(value, expected)
        for value, expected in zip(results[2], results[1]):
            self.assertTrue(torch.equal(value, expected.cpu()))

    def test_the_boundary_changes_no_bit(self):
        values = gaussians(GPU)
        tensors = list(values.values())
        points = torch.zeros(COUNT, 2, device=GPU, requires_grad=True)
        sums = torch.zeros(COUNT, 2, device=GPU, requires_grad=True)
        fused = self.drawn(values, screen_points=points, absolute_points=sums)
        split = self.drawn(values, boundary=True, absolute_points=sums)
        for a, b in zip(split[:5], fused[:5]):
            self.assertTrue(torch.equal(a, b))
        expected = torch.autograd.grad(loss_of(fused[:4]), [*tensors, points, sums])
        found = torch.autograd.grad(loss_of(split[:4]), [*tensors, split.boundary.means_px, sums])
        for number, (a, b) in enumerate(zip(found, expected)):
            self.assertTrue(torch.equal(a, b), number)
            self.assertEqual(a.device, GPU)
        self.assertTrue((expected[-1] >= expected[-2].abs() - 1e-4).all())

    def test_frames_wait_for_their_backward_passes(self):
        values = gaussians(GPU)
        tensors = list(values.values())

        def loss(size):
            return loss_of(rasterize(**values, camera=camera().resized(size, size))[:4])

        alone = [torch.autograd.grad(loss(size), tensors) for size in (8, 20, 33)]
        waiting = [loss(size) for size in (8, 20, 33)]
        for frame, expected in reversed(list(zip(waiting, alone))):
            for _ in range(2):
                found = torch.autograd.grad(frame, tensors, retain_graph=True)
                self.assertTrue(all(torch.equal(a, b) for a, b in zip(found, expected)))

    def test_saved_memory_may_move(self):
        values = gaussians(GPU)
        tensors = list(values.values())
        expected = torch.autograd.grad(loss_of(self.drawn(values)[:4]), tensors)
        with torch.autograd.graph.save_on_cpu():
            loss = loss_of(self.drawn(values)[:4])
        found = torch.autograd.grad(loss, tensors)
        self.assertTrue(all(torch.equal(a, b) for a, b in zip(found, expected)))

    def test_a_change_in_place_is_noticed(self):
        values = gaussians(GPU)
        loss = loss_of(self.drawn(values)[:4])
        with torch.no_grad():
            values["means"] += 1
        with self.assertRaisesRegex(RuntimeError, "modified by an inplace operation"):
            loss.backward()

    def test_the_current_stream_orders_the_work(self):
        expected = self.drawn(gaussians(GPU)).color
        torch.cuda.synchronize()
        side = torch.cuda.Stream()
        values = gaussians(GPU)
        with torch.cuda.stream(side):
            slow = torch.zeros(1, device=GPU)
            for _ in range(20):
                torch.cuda._sleep(1_000_000)
            late = {name: value.detach() + slow for name, value in values.items()}  # ready much later
            late = {name: value.requires_grad_() for name, value in late.items()}
            drawn = self.drawn(late)
            loss_of(drawn[:4]).backward()
        side.synchronize()
        self.assertTrue(torch.equal(drawn.color, expected))
        self.assertTrue(torch.isfinite(late["means"].grad).all())

    def test_threads_draw_at_the_same_time(self):
        expected = self.drawn(gaussians(GPU)).color
        wrong = []

        def work():
            for _ in range(5):
                values = gaussians(GPU)
                drawn = self.drawn(values)
                loss_of(drawn[:4]).backward()
                if not torch.equal(drawn.color, expected):
                    wrong.append(drawn)

        threads = [threading.Thread(target=work) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertFalse(wrong)

    def test_a_new_thread_draws_first_of_all(self):
        values = gaussians(GPU)
        by = torch.ones(HEIGHT, WIDTH, 3, device=GPU)
        expected = self.drawn(values, outputs="color").color  # leaves memory in torch's cache
        found = []

        def work():
            color = self.drawn(values, outputs="color").color
            found.extend([color, *torch.autograd.grad(color, list(values.values()), by)])

        thread = threading.Thread(target=work)
        thread.start()
        thread.join()
        self.assertTrue(torch.equal(found[0], expected))
        self.assertEqual(len(found), 6)

    def test_memory_is_given_back(self):
        def run():
            values = gaussians(GPU)
            loss_of(self.drawn(values)[:4]).backward()

        run()
        torch.cuda.synchronize()
        before = torch.cuda.memory_allocated()
        for _ in range(5):
            run()
        self.assertLessEqual(torch.cuda.memory_allocated(), before)


class Refusals(CudaTest):
    def refused(self, sentence, **options):
        values = {name: value.detach() for name, value in gaussians(GPU).items()}
        with self.assertRaises(quadsplat.UsageError) as raised:
            rasterize(**{**values, "camera": camera(), **options})
        self.assertIn(sentence, str(raised.exception))

    def test_mixed_devices_get_a_sentence(self):
        self.refused("rasterize: scales is on the device cpu, but means is on cuda:0",
                     scales=torch.ones(COUNT, 3))
        self.refused("rasterize: scales is on the device cuda:0, but means is on cpu",
                     means=torch.ones(COUNT, 3))

    def test_double_precision_gets_a_sentence(self):
        values = {name: value.detach().double() for name, value in gaussians(GPU).items()}
        self.refused("float64, which only the CPU computes", **values)

    def test_a_context_of_the_cpu_gets_a_sentence(self):
        with quadsplat.Context("cpu") as context:
            self.refused("the context has the backend cpu", context=context)

    def test_a_background_on_the_cpu_is_copied(self):
        values = gaussians(GPU)
        background = torch.tensor([0.2, 0.5, 0.9], requires_grad=True)
        on_gpu = background.detach().to(GPU).requires_grad_()
        color, expected = (self.drawn(values, background=given).color for given in (background, on_gpu))
        self.assertTrue(torch.equal(color, expected))
        self.assertTrue(torch.equal(torch.autograd.grad(color.sum(), background)[0],
                                    torch.autograd.grad(expected.sum(), on_gpu)[0].cpu()))


class Parts(CudaTest):
    def test_ssim(self):
        draw = torch.Generator().manual_seed(1)
        pictures = [torch.rand(2, 3, 30, 40, generator=draw) for _ in range(2)]
        for padding in ("same", "valid"):
            results = []
            for device in ("cpu", GPU):
                a, b = (picture.to(device).requires_grad_() for picture in pictures)
                value = ssim(a, b, padding)
                results.append([value, *torch.autograd.grad(2 * value, (a, b))])
            for value, expected in zip(results[1], results[0]):
                self.close(value, expected, 1e-4)
        a, b = (picture.to(GPU) for picture in pictures)
        for change, sentence in ((dict(b=b[:1]), "b has the shape"), (dict(b=b.cpu()), "b is on the device cpu"),
                                 (dict(a=a[0], b=b[0]), "a has the shape"), (dict(padding="all"), "is none of"),
                                 (dict(a=a[..., :9], b=b[..., :9], padding="valid"), "11 pixels")):
            with self.assertRaisesRegex(quadsplat.UsageError, sentence):
                ssim(**{"a": a, "b": b, **change})

    def test_pictures_are_compared_on_the_gpu(self):
        draw = torch.Generator().manual_seed(1)
        a, b = (torch.rand(30, 40, 3, generator=draw) for _ in range(2))
        mask = torch.rand(30, 40, generator=draw) > 0.3
        for options in (dict(mask=mask), dict(ssim_border="crop"), dict(metrics=("psnr_8bit", "flip"))):
            expected = quadsplat.compare(a, b, **options)
            on_gpu = {name: value.to(GPU) if name == "mask" else value for name, value in options.items()}
            # Planes of the channels on the GPU.
            planes = b.permute(2, 0, 1).contiguous().to(GPU).permute(1, 2, 0)
            for value, wanted in zip(quadsplat.compare(a.to(GPU), planes, **on_gpu), expected):
                self.assertEqual(math.isnan(value), math.isnan(wanted))
                self.assertTrue(math.isnan(value) or abs(value - wanted) <= 1e-9 * abs(wanted))
        for change, sentence in ((dict(picture=b), "copy it to the host first"),
                                 (dict(mask=mask), "compare: mask: is in host memory"),
                                 (dict(picture=b.to(GPU)[:5]), "picture has the shape"),
                                 (dict(context=quadsplat.Context("cpu")), "the context has the backend cpu")):
            with self.assertRaisesRegex(quadsplat.UsageError, sentence):
                quadsplat.compare(**{"reference": a.to(GPU), "picture": b.to(GPU), **change})

    def test_views_are_added_in_the_stream_and_torch_notices(self):
        from quadsplat.torch._parts import add_view
        count = 5000
        gradients, radii = torch.randn(count, 2), torch.randint(0, 3, (count, 2), dtype=torch.int32)
        found = []
        for device in ("cpu", GPU):
            lengths, views = torch.zeros(count, device=device), torch.zeros(count, device=device)
            for _ in range(2):
                add_view(gradients.to(device), radii.to(device), (400.0, 300.0), lengths, views)
            self.assertEqual((lengths._version, views._version), (2, 2))
            found.append((lengths.cpu(), views.cpu()))
        seen = (radii > 0).all(1)
        wanted = 2 * seen * (gradients * torch.tensor([400.0, 300.0])).norm(dim=1)
        for lengths, views in found:
            self.assertTrue(torch.allclose(lengths, wanted, rtol=1e-6))
            self.assertTrue(torch.equal(views, 2.0 * seen))

    def test_ssim_and_l1_read_any_strides_without_a_wait(self):
        draw = torch.Generator().manual_seed(1)
        pictures = [torch.rand(1, 30, 40, 3, generator=draw) for _ in range(2)]
        results = []
        for device in ("cpu", GPU):
            a, b = (picture.to(device).permute(0, 3, 1, 2) for picture in pictures)
            a.requires_grad_()
            means = ssim_and_l1(a, b, "valid")
            results.append([*means, torch.autograd.grad(means[0] + 3 * means[1], a)[0]])
        for value, expected in zip(results[1], results[0]):
            self.close(value, expected, 1e-5)
        self.assertTrue(torch.equal(results[1][2].cpu(), results[0][2]))

    def test_noise_and_covariances(self):
        from quadsplat.dropin import _gsplat

        draw = torch.Generator().manual_seed(8)
        means, scales, noise = (torch.randn(50, 3, generator=draw) for _ in range(3))
        quats, logits = torch.randn(50, 4, generator=draw), torch.randn(50, generator=draw)
        for triu in (False, True):
            for found, expected in zip(_gsplat.quat_scale_to_covar_preci(quats.to(GPU), scales.exp().to(GPU), triu=triu),
                                       _gsplat.quat_scale_to_covar_preci(quats, scales.exp(), triu=triu)):
                self.close(found, expected, 1e-4)
        moved = means.to(GPU)
        self.assertTrue(_gsplat._cuda_fused_mcmc_perturb(moved, quats.to(GPU), scales.to(GPU), logits[:, None].to(GPU), 0.1))
        self.assertTrue(moved.isfinite().all() and (moved.cpu() != means).any())
        add_noise(means, quats, scales, logits, noise, 0.1, 2.0, 0.3)
        on_gpu = [value.to(GPU) for value in (torch.zeros_like(means), quats, scales, logits, noise)]
        on_host = [value.cpu() for value in on_gpu]
        add_noise(*on_gpu, 0.1, 2.0, 0.3)
        add_noise(*on_host, 0.1, 2.0, 0.3)
        self.close(on_gpu[0], on_host[0], 1e-6)

    def test_memory_is_kept_and_freed(self):
        from quadsplat.torch import _memory

        def step():
            values = gaussians(GPU)
            picture = rasterize(**values, camera=camera()).color
            picture.sum().backward()

        gc.collect()  # frames of other tests
        _memory.free_all()
        for _ in range(3):
            step()
        torch.cuda.synchronize()
        kept = {block.tensor.data_ptr() for blocks in _memory._blocks.values() for block in blocks}
        self.assertEqual(len(kept), 3)
        torch.cuda.empty_cache()
        step()
        self.assertEqual({block.tensor.data_ptr() for blocks in _memory._blocks.values() for block in blocks}, kept)
        _memory.free_unused()
        _memory.free_unused()
        self.assertFalse(any(_memory._blocks.values()) or _memory._arenas)
        step()

    def test_sparse_adam(self):
        draw = torch.Generator().manual_seed(4)
        start, gradients = torch.randn(20, 3, 2, generator=draw), torch.randn(3, 20, 3, 2, generator=draw)
        gradients[1, 3] = float("nan")
        visible = torch.rand(3, 20, generator=draw) < 0.5
        results = []
        for device in ("cpu", GPU):
            param = start.clone().to(device).requires_grad_()
            optimiser = SparseAdam([{"params": [param]}], lr=1e-2)
            for gradient, rows in zip(gradients, visible):
                param.grad = gradient.to(device)
                optimiser.step(rows.to(device), 20)
            results.append([param, *(optimiser.state[param][name] for name in ("exp_avg", "exp_avg_sq"))])
        for value, expected in zip(results[1], results[0]):
            self.assertTrue(torch.equal(value.detach().cpu(), expected.detach()))
            self.assertGreater(value._version, 0)  # torch notices the change
        with self.assertRaisesRegex(quadsplat.UsageError, "adam: gradients has elements of type torch.float64 instead of float32"):
            doubles = torch.zeros(20, 3, 2, dtype=torch.float64, device=GPU)
            adam([Step(param.detach(), doubles, *(torch.zeros_like(param) for _ in range(2)), 0.1, (0.9, 0.999), 1e-8)], None)

    def test_a_training_loop_learns(self):
        with torch.no_grad():
            wanted = self.drawn(gaussians(GPU)).color
        values = {name: (value + 0.05 * torch.randn_like(value)).detach().requires_grad_()
                  for name, value in gaussians(GPU).items() if name != "opacities"}
        opacities = gaussians(GPU)["opacities"].detach()
        optimiser = torch.optim.Adam(list(values.values()), lr=2e-3)
        losses = []
        for _ in range(60):
            optimiser.zero_grad()
            color = self.drawn({**values, "opacities": opacities}, outputs="color").color
            loss = (color - wanted).abs().mean()
            loss.backward()
            optimiser.step()
            losses.append(loss.item())
        self.assertLess(losses[-1], 0.6 * losses[0])


class DropIns(CudaTest):
    def test_the_family_of_inria(self):
        from quadsplat.dropin import _inria

        focal = (63.0, 66.0)
        view = torch.tensor(camera().view_from_world, dtype=torch.float32)
        lens = torch.zeros(4, 4)
        lens[0, 0], lens[1, 1] = 2 * focal[0] / WIDTH, 2 * focal[1] / HEIGHT
        lens[2, 2], lens[2, 3], lens[3, 2] = 1.0001, -0.01, 1
        results = []
        for device in ("cpu", GPU):
            values = gaussians(device)
            tangents = [size / (2 * length) for size, length in zip((WIDTH, HEIGHT), focal)]
            settings = _inria.GaussianRasterizationSettings(
                HEIGHT, WIDTH, *tangents, torch.tensor([0.1, 0.3, 0.6]).to(device), 1.0,
                view.T.to(device), (view.T @ lens.T).to(device), 2,
                torch.inverse(view)[:3, 3].to(device), antialiasing=False)
            points = torch.zeros_like(values["means"], requires_grad=True)
            color, radii, inverse = _inria.GaussianRasterizer(settings)(
                values["means"], points, values["opacities"][:, None], shs=values["sh"],
                scales=values["scales"], rotations=torch.nn.functional.normalize(values["rotations"]))
            loss_of([color, inverse]).backward()
            results.append([color, inverse, points.grad, *(value.grad for value in values.values())])
            self.assertEqual(radii.device, values["means"].device)
        for value, expected in zip(results[1], results[0]):
            self.close(value, expected)

    def test_the_variant_with_a_pose(self):
        from quadsplat.dropin import _inria

        lens = torch.zeros(4, 4)
        lens[0, 0], lens[1, 1] = 2 * 63.0 / WIDTH, 2 * 66.0 / HEIGHT
        lens[2, 2], lens[2, 3], lens[3, 2] = 1.0001, -0.01, 1
        view = torch.tensor(camera().view_from_world, dtype=torch.float32)
        results = []
        for device in ("cpu", GPU):
            values = gaussians(device)
            theta, rho = (torch.zeros(3, device=device, requires_grad=True) for _ in range(2))
            settings = _inria.GaussianRasterizationSettings(
                HEIGHT, WIDTH, WIDTH / 126, HEIGHT / 132, torch.zeros(3, device=device), 1.0,
                view.T.to(device), (view.T @ lens.T).to(device), 2,
                torch.inverse(view)[:3, 3].to(device), projmatrix_raw=lens.T.to(device))
            color, _, depth, opacity, touched = _inria.GaussianRasterizer(settings)(
                values["means"], torch.zeros_like(values["means"]), values["opacities"][:, None],
                shs=values["sh"], scales=values["scales"],
                rotations=torch.nn.functional.normalize(values["rotations"]), theta=theta, rho=rho)
            loss_of([color, depth, opacity]).backward()
            results.append([color, depth, opacity, theta.grad, rho.grad])
            self.assertEqual(touched.device, values["means"].device)
            self.assertGreater(int(touched.max()), 10)
        for value, expected in zip(results[1], results[0]):
            self.close(value, expected)

    def test_scenes_and_signals_of_gsplat(self):
        from quadsplat.dropin import _gsplat

        results = []
        for device in ("cpu", GPU):
            values = {name: torch.stack([value.detach(), 0.9 * value.detach()]).requires_grad_()
                      for name, value in gaussians(device).items()}
            views = torch.tensor(camera().view_from_world, dtype=torch.float32).expand(2, 1, 4, 4).to(device)
            lens = torch.tensor([[63.0, 0, 35], [0, 66, 25], [0, 0, 1]]).expand(2, 1, 3, 3).to(device)
            signals = torch.rand(2, COUNT, 2, generator=torch.Generator().manual_seed(6)).to(device)
            colors, alphas, info = _gsplat.rasterization(
                values["means"], values["rotations"], values["scales"], values["opacities"],
                values["sh"], views, lens, WIDTH, HEIGHT, sh_degree=2, packed=False,
                extra_signals=signals)
            drawn = [colors, alphas, info["render_extra_signals"]]
            results.append([*drawn, *torch.autograd.grad(loss_of(drawn), list(values.values()))])
        for value, expected in zip(results[1], results[0]):
            self.close(value, expected)

    def test_gsplat(self):
        from quadsplat.dropin import _gsplat

        results = []
        for device in ("cpu", GPU):
            values = gaussians(device)
            views = torch.tensor(camera().view_from_world, dtype=torch.float32)[None].to(device)
            lens = torch.tensor([[[63.0, 0, 35], [0, 66, 25], [0, 0, 1]]]).to(device)
            for packed in (True, False):
                colors, alphas, info = _gsplat.rasterization(
                    values["means"], values["rotations"], values["scales"], values["opacities"],
                    values["sh"], views, lens, WIDTH, HEIGHT, sh_degree=2, packed=packed,
                    render_mode="RGB+ED")
                info["means2d"].retain_grad()
                by = torch.autograd.grad(loss_of([colors, alphas]), [*values.values(), info["means2d"]])
                results.append([colors, alphas, *by[:-1]])
        for number in range(2):
            for value, expected in zip(results[2 + number], results[number]):
                self.close(value, expected)

    def test_the_small_modules(self):
        from quadsplat.dropin import _gsplat, _inria

        simple_knn = importlib.import_module("quadsplat.dropin.modules.simple_knn._C")
        points = torch.rand(50, 3, generator=torch.Generator().manual_seed(2))
        self.close(simple_knn.distCUDA2(points.to(GPU)), simple_knn.distCUDA2(points))
        opacities, scales, counts = torch.tensor([0.5, 0.9]), torch.ones(2, 3), torch.tensor([2, 3])
        for function in (_inria.compute_relocation, _gsplat.compute_relocation):
            found = function(opacities.to(GPU), scales.to(GPU), counts.to(GPU))
            for value, expected in zip(found, function(opacities, scales, counts)):
                self.close(value, expected)


if __name__ == "__main__":
    unittest.main()
