# SPDX-License-Identifier: MIT
"""The parts of a trainer, against plain numpy."""
import numpy as np
import pytest

RANDOM = np.random.default_rng(1)


def ssim_of(a, b, margin):
    """SSIM by its definition."""
    weights = np.exp(-np.arange(-5, 6) ** 2 / 4.5)
    weights /= weights.sum()

    def mean(values):
        padded = np.pad(values, [(0, 0), (0, 0), (5, 5), (5, 5)])
        rows = sum(w * padded[:, :, i:i + values.shape[2]] for i, w in enumerate(weights))
        return sum(w * rows[..., i:i + values.shape[3]] for i, w in enumerate(weights))

    ma, mb, c1, c2 = mean(a), mean(b), 1e-4, 9e-4
    va, vb, ab = mean(a * a) - ma * ma, mean(b * b) - mb * mb, mean(a * b) - ma * mb
    map_of = (2 * ma * mb + c1) * (2 * ab + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2))
    end = -margin or None
    return map_of[:, :, margin:end, margin:end].mean()


@pytest.mark.parametrize("padding, margin", [("same", 0), ("valid", 5)])
def test_ssim_and_its_gradient_are_those_of_the_definition(quadsplat, padding, margin):
    a, b = RANDOM.random((2, 2, 3, 14, 12))
    assert quadsplat.ssim(a, b, padding=padding) == pytest.approx(ssim_of(a, b, margin), abs=1e-12)
    singles = a.astype(np.float32), b.astype(np.float32)
    assert quadsplat.ssim(*singles, padding=padding) == pytest.approx(ssim_of(a, b, margin), abs=1e-5)
    gradient = quadsplat.ssim_backward(a, b, 2, padding=padding)
    assert gradient.dtype == np.float64 and gradient.shape == a.shape
    for at in [(0, 0, 0, 0), (1, 2, 13, 11), (0, 1, 7, 6), (1, 0, 3, 10)]:
        moved = a.copy()
        moved[at] += 1e-5
        above = quadsplat.ssim(moved, b, padding=padding)
        moved[at] -= 2e-5
        difference = (above - quadsplat.ssim(moved, b, padding=padding)) / 1e-5
        assert gradient[at] == pytest.approx(difference, abs=1e-8)
    assert quadsplat.ssim_backward(*singles, 2, padding=padding) == pytest.approx(gradient, abs=1e-4)


def test_ssim_reads_any_strides_and_does_not_depend_on_threads(quadsplat):
    a, b = RANDOM.random((2, 1, 3, 40, 30)).astype(np.float32)
    turned = np.ascontiguousarray(a.transpose(3, 0, 2, 1)).transpose(1, 3, 2, 0)
    with quadsplat.Context("cpu", threads=1) as one, quadsplat.Context("cpu", threads=3) as three:
        assert quadsplat.ssim(a, b, context=one) == quadsplat.ssim(turned, b, context=three)
        gradient = quadsplat.ssim_backward(a, b, context=one)
        assert np.array_equal(gradient, quadsplat.ssim_backward(turned, b, context=three))
    assert np.isnan(quadsplat.ssim(a * np.nan, b))


def test_neighbours_are_the_three_nearest_points(quadsplat):
    points = RANDOM.normal(size=(200, 3)).astype(np.float32)
    points[7] = points[8]
    squared = ((points[:, None].astype(float) - points) ** 2).sum(-1)
    np.fill_diagonal(squared, np.inf)
    expected = np.sort(squared, axis=1)[:, :3].mean(axis=1)
    found = quadsplat.neighbours(points)
    assert found.dtype == np.float32 and found == pytest.approx(expected, rel=1e-6)
    assert np.array_equal(quadsplat.neighbours(points[::-1].astype(np.float64)), found[::-1])
    for few, means in [([], []), ([[1, 2, 3]], [0]), ([[0, 0, 0], [0, 3, 4]], [25, 25]),
                       ([[1, 1, 1]] * 4, [0] * 4),
                       ([[0, 0, 0], [np.nan, 0, 0], [0, 0, 2]], [4, np.nan, 4])]:
        array = np.array(few, np.float32).reshape(-1, 3)
        assert np.array_equal(quadsplat.neighbours(array), np.array(means, np.float32), equal_nan=True)


def test_relocate_is_equation_9(quadsplat):
    from math import comb

    opacities, scales = RANDOM.uniform(0.1, 0.9, 6), RANDOM.random((6, 3))
    counts = np.array([1, 2, 3, 5, 8, 12])
    new_opacities, new_scales = quadsplat.relocate(opacities, scales, counts)
    for i, copies in enumerate(counts):
        after = 1 - (1 - opacities[i]) ** (1 / copies)
        total = sum(comb(n - 1, k) * (-1) ** k * after ** (k + 1) / np.sqrt(k + 1)
                    for n in range(1, copies + 1) for k in range(n))
        assert new_opacities[i] == pytest.approx(after, rel=1e-12)
        assert new_scales[i] == pytest.approx(scales[i] * opacities[i] / total, rel=1e-9)
    column, singles = quadsplat.relocate(opacities[:, None].astype(np.float32),
                                         scales.astype(np.float32), counts[:, None].astype(">i2"))
    assert column.shape == (6, 1) and column.dtype == singles.dtype == np.float32
    assert column[:, 0] == pytest.approx(new_opacities, rel=1e-6)
    same, _ = quadsplat.relocate([0.5, np.nan, 2], np.ones((3, 3)), [-5, 2, 2])
    assert np.array_equal(same, [0.5, np.nan, 2], equal_nan=True)
    most = quadsplat.relocate([0.5, 0.5], np.ones((2, 3)), [51, 2**62])
    assert most[0][0] == most[0][1]


@pytest.mark.parametrize("step", [0, 3])
def test_adam_moves_visible_rows_by_its_formula(quadsplat, step):
    shape = (7, 4, 3)
    values, gradients, first = RANDOM.normal(size=(3, *shape)).astype(np.float32)
    second = RANDOM.random(shape).astype(np.float32)
    visible = np.array([1, 0, 1, 1, 0, 0, 1], bool)
    old = [array.copy() for array in (values, first, second)]
    quadsplat.adam(values, gradients, first, second, 0.1, visible=visible, step=step,
                   betas=(0.8, 0.9), epsilon=1e-3)
    m, v = 0.8 * old[1] + 0.2 * gradients, 0.9 * old[2] + 0.1 * gradients**2
    right = (1, 1) if step == 0 else (1 - 0.8**step, 1 - 0.9**step)
    moved = old[0] - 0.1 * (m / right[0]) / (np.sqrt(v / right[1]) + 1e-3)
    for array, new, before in zip((values, first, second), (moved, m, v), old):
        assert array[visible] == pytest.approx(new[visible], abs=1e-5)
        assert np.array_equal(array[~visible], before[~visible])


def test_adam_changes_views_in_place(quadsplat):
    memory = np.zeros((4, 6), np.float32)
    view = memory[:, ::2].T  # 3 x 4
    first, second = np.zeros((2, 3, 4), np.float32)
    gradients = np.full((3, 4), np.nan)
    gradients[1] = 1
    quadsplat.adam(view, gradients, first, second, 0.5, step=1)
    assert np.array_equal(view, np.array([0, -0.5, 0])[:, None] * np.ones(4))
    assert not memory[:, 1::2].any() and np.isfinite(first).all()
    quadsplat.adam(*np.zeros((4, 0, 3), np.float32), 1)


def test_adam_changes_tensors_in_place(quadsplat):
    torch = pytest.importorskip("torch", reason="torch is not installed (python3-torch)")
    values = torch.zeros(4, 3).requires_grad_()
    first, second = torch.zeros(3, 4).T, torch.zeros(4, 6)[:, ::2]
    visible = torch.tensor([True, False, True, True])
    square = values ** 2
    quadsplat.adam(values, torch.ones(4, 3), first, second, 0.5, step=1, visible=visible)
    assert values.tolist() == [[-0.5] * 3, [0] * 3, [-0.5] * 3, [-0.5] * 3]
    assert first[0].tolist() == pytest.approx([0.1] * 3) and not first[1].any()
    assert second[0].tolist() == pytest.approx([0.001] * 3)
    with pytest.raises(RuntimeError, match="modified by an inplace operation"):
        square.sum().backward()  # torch noticed the change
    for shape in [(4, 1), (4, 1, 3), (4,), (1, 3), (0, 3), (4, 0)]:
        tensors = [torch.zeros(shape) for _ in range(3)]
        quadsplat.adam(tensors[0], torch.ones(shape), *tensors[1:], 0.5, step=1)
        assert (tensors[0] == -0.5).all(), shape
    for changes, sentence in [
            ({"first": torch.zeros(1, 3).expand(4, 3)}, "^adam: first: its stride of dimension 0 is 0"),
            ({"values": torch.zeros(4, 3, dtype=torch.float64)}, "^adam: values has elements of type float64"),
            ({"values": torch.zeros(4, 3, device="meta")}, "^adam: values cannot be read as an array")]:
        arrays = {"values": values, "first": first, "second": second, **changes}
        with pytest.raises(quadsplat.UsageError, match=sentence):
            quadsplat.adam(gradients=torch.ones(4, 3), rate=0.5, **arrays)


def test_wrong_arguments_get_a_sentence(quadsplat):
    pictures = np.zeros((1, 1, 10, 12))
    with pytest.raises(quadsplat.UsageError, match=r"^ssim: b has the shape \(1, 1, 9, 12\) instead "):
        quadsplat.ssim(pictures, pictures[:, :, 1:])
    with pytest.raises(quadsplat.UsageError, match=r"^ssim: a has the shape \(10, 12\) instead of "):
        quadsplat.ssim(pictures[0, 0], pictures[0, 0])
    with pytest.raises(quadsplat.UsageError, match="^ssim: padding: 'full' is none of 'same', 'val"):
        quadsplat.ssim(pictures, pictures, padding="full")
    with pytest.raises(quadsplat.UsageError, match="^ssim: border: QS_BORDER_CROP needs 11 pixels "):
        quadsplat.ssim(pictures, pictures, padding="valid")
    with pytest.raises(quadsplat.UsageError, match="^ssim_backward: by_mean is 'x' instead of a nu"):
        quadsplat.ssim_backward(pictures, pictures, "x")
    with pytest.raises(quadsplat.UsageError, match=r"^neighbours: points has the shape \(3, 2\) "):
        quadsplat.neighbours(np.zeros((3, 2)))
    with pytest.raises(quadsplat.UsageError, match="^relocate: counts has elements of type float64"):
        quadsplat.relocate([0.5], [[1, 1, 1]], [2.0])
    with pytest.raises(quadsplat.UsageError, match=r"^relocate: scales has the shape \(2, 3\) inst"):
        quadsplat.relocate([0.5], np.ones((2, 3)), [2])

    def step(**changes):
        arrays = {name: np.zeros((2, 3), np.float32)
                  for name in ("values", "gradients", "first", "second")}
        return quadsplat.adam(**{"rate": 1, **arrays, **changes})

    step()
    for changes, sentence in [
            ({"values": np.zeros((2, 3))}, "values has elements of type float64 instead of float32"),
            ({"values": np.zeros((), np.float32)}, "values has 0 dimensions instead of 1 to 4"),
            ({"values": np.broadcast_to(np.float32(1), (2, 3))}, "values cannot be changed in place"),
            ({"first": np.zeros((3, 2), np.float32)}, "first has the shape (3, 2) instead of (2, 3)"),
            ({"visible": [1, 0]}, "visible has elements of type int64 instead of bool or uint8"),
            ({"visible": np.ones(3, bool)}, "visible has the shape (3,) instead of (2,)"),
            ({"betas": 0.9}, "betas is 0.9 instead of 2 numbers"),
            ({"betas": (0.9, 1)}, "beta2: 1 is not at least 0 and below 1"),
            ({"rate": float("nan")}, "rate: is nan"),
            ({"step": -1}, "step: -1 is not between 0 and 9223372036854775807")]:
        with pytest.raises(quadsplat.UsageError) as error:
            step(**changes)
        assert str(error.value) == f"adam: {sentence}"
