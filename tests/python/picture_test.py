# SPDX-License-Identifier: MIT
"""Pictures in files, in notebooks, and compared."""
import zlib

import numpy as np
import pytest

from conftest import PLUSH


@pytest.fixture(scope="module")
def picture(quadsplat, scene, camera):
    return quadsplat.render(scene, camera, outputs=["color", "alpha", "depth", "pairs"])


def png_pixels(content):
    """The rows of a PNG of 8 bits, without its library: only the filters that are needed."""
    assert content.startswith(b"\x89PNG\r\n\x1a\n")
    data, at = b"", 8
    while at < len(content):
        size = int.from_bytes(content[at:at + 4], "big")
        kind, body = content[at + 4:at + 8], content[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height = int.from_bytes(body[:4], "big"), int.from_bytes(body[4:8], "big")
            channels = {0: 1, 2: 3}[body[9]]
            assert body[8] == 8
        if kind == b"IDAT":
            data += body
        at += 12 + size
    rows = np.frombuffer(zlib.decompress(data), np.uint8).reshape(height, -1)
    image = np.zeros((height, width * channels), np.int64)
    for y, (kind, row) in enumerate(zip(rows[:, 0], rows[:, 1:].astype(np.int64))):
        above = image[y - 1] if y else np.zeros_like(row)
        for x in range(len(row)):
            left = image[y, x - channels] if x >= channels else 0
            corner = above[x - channels] if x >= channels else 0
            guess = left + above[x] - corner
            paeth = min((left, above[x], corner), key=lambda value: abs(guess - value))
            add = [0, left, above[x], (left + above[x]) // 2, paeth][kind]
            image[y, x] = (row[x] + add) % 256
    return image.reshape(height, width, channels).astype(np.uint8)


def test_a_notebook_shows_the_colours(quadsplat, picture, scene, camera):
    content = picture._repr_png_()
    bytes_of = quadsplat.render(scene, camera, dtype="uint8")
    assert np.array_equal(png_pixels(content), bytes_of.color)
    assert bytes_of._repr_png_() == content
    alpha = quadsplat.render(scene, camera, outputs="alpha", dtype="uint8")
    assert np.array_equal(png_pixels(alpha._repr_png_())[..., 0], alpha.alpha)
    assert quadsplat.render(scene, camera, outputs="depth")._repr_png_() is None
    assert "150 x 101, cull quadbox" in repr(picture)


def test_files_hold_the_values(quadsplat, picture, tmp_path):
    for ending in (".npy", ".pfm"):
        for what in ("color", "alpha", "depth"):
            path = tmp_path / f"{what}{ending}"
            picture.save(path, what)
            values = quadsplat.read_picture(path)
            expected = getattr(picture, what)
            assert values.dtype == np.float32
            assert np.array_equal(values.reshape(expected.shape), expected)
    picture.save(tmp_path / "pairs.npy", "pairs")
    assert np.array_equal(np.load(tmp_path / "pairs.npy").reshape(picture.pairs.shape),
                          picture.pairs)
    for ending in (".png", ".ppm"):
        picture.save(tmp_path / f"a{ending}")
        rounded = np.floor(np.float32(255) * np.clip(picture.color, 0, 1) + np.float32(0.5))
        assert np.array_equal(np.rint(quadsplat.read_picture(tmp_path / f"a{ending}") * 255),
                              rounded)


def test_a_file_has_the_pixels_that_the_program_writes(quadsplat, picture, program, tmp_path):
    program("render", PLUSH, "--backend", "cpu", "--camera-index", 32, "--size", "150x101",
            "--output", tmp_path / "program.png")
    picture.save(tmp_path / "package.png")
    assert np.array_equal(quadsplat.read_picture(tmp_path / "package.png"),
                          quadsplat.read_picture(tmp_path / "program.png"))


def test_the_programs_rule_of_overwriting_holds(quadsplat, picture, tmp_path):
    picture.save(tmp_path / "a.png")
    picture.save(tmp_path / "a.png")
    (tmp_path / "b.png").write_bytes(b"of the user")
    with pytest.raises(quadsplat.UsageError, match="b.png.*overwrite"):
        picture.save(tmp_path / "b.png")
    assert (tmp_path / "b.png").read_bytes() == b"of the user"
    picture.save(tmp_path / "b.png", overwrite=True)
    assert quadsplat.read_picture(tmp_path / "b.png").shape == (101, 150, 3)
    with pytest.raises(quadsplat.Error, match="no/a.png"):
        picture.save(tmp_path / "no" / "a.png")


def test_wrong_pictures_are_refused_in_a_sentence(quadsplat, picture, tmp_path):
    for act, sentence in [
            (lambda: picture.save(tmp_path / "a.png", "depth"),
             "Picture.save: depth is not between 0 and 1: write it as .npy or .pfm"),
            (lambda: picture.save(tmp_path / "a.npy", "used"),
             "Picture.save: used was not rendered: add it to the outputs of render()"),
            (lambda: picture.save(tmp_path / "a.npy", "colour"), "Picture.save: 'colour' is none"),
            (lambda: picture.save(tmp_path / "a"), "the name needs an ending"),
            (lambda: picture.save(3.5), "Picture.save: path is 3.5 instead of a path"),
            (lambda: picture.save("a\0b.png"), "Picture.save: path has a character of code 0")]:
        with pytest.raises(quadsplat.UsageError) as raised:
            act()
        assert sentence in str(raised.value)
    (tmp_path / "bad.png").write_bytes(b"\x89PNG\r\n\x1a\nnothing")
    for name in ("bad.png", "none.png"):
        with pytest.raises(quadsplat.InputError, match=name):
            quadsplat.read_picture(tmp_path / name)


def test_metrics_are_those_of_their_definitions(quadsplat, picture):
    other = np.clip(picture.color + np.float32(0.125), 0, 1)
    clamped = np.clip(picture.color, 0, 1).astype(np.float64)
    error = ((clamped - other) ** 2).mean()
    assert picture.psnr(other) == pytest.approx(-10 * np.log10(error), abs=1e-4)
    assert picture.psnr(picture) == float("inf") and picture.ssim(picture) == pytest.approx(1)
    assert 0 < picture.ssim(other) < 1
    whole = quadsplat.compare(picture, other, metrics=("psnr", "psnr_8bit", "ssim", "flip"))
    assert whole.psnr == picture.psnr(other) and whole.ssim == picture.ssim(other)
    assert whole.psnr_8bit == pytest.approx(whole.psnr, abs=0.1) and 0 < whole.flip < 1
    only = quadsplat.compare(picture, other, metrics="flip")
    assert only.flip == whole.flip and np.isnan(only.psnr) and np.isnan(only.ssim)
    assert quadsplat.compare(picture, other, metrics=["psnr", "psnr"]).psnr == whole.psnr


def test_pictures_are_compared_in_every_form(quadsplat, picture, tmp_path):
    picture.save(tmp_path / "a.npy")
    other = np.ascontiguousarray(picture.color[::-1])
    expected = quadsplat.compare(picture, other)
    assert quadsplat.compare(tmp_path / "a.npy", other) == expected
    assert quadsplat.compare(str(tmp_path / "a.npy"), other.tolist()) == expected
    assert quadsplat.compare(np.asarray(picture), picture.color[::-1]) == expected
    planes = other.transpose(2, 0, 1).copy()
    assert quadsplat.compare(picture, planes.transpose(1, 2, 0)) == expected
    assert quadsplat.compare(picture, other.astype(np.float64)) == expected
    assert quadsplat.compare(picture, other.astype(">f4")) == expected
    half = quadsplat.compare(picture, other.astype(np.float16))
    assert half.psnr == pytest.approx(expected.psnr, abs=0.01)


def test_a_mask_leaves_out_pixels(quadsplat, picture):
    other = picture.color.copy()
    other[:50] = 0
    mask = np.ones(other.shape[:2], bool)
    mask[:50] = False
    assert quadsplat.compare(picture, other, metrics="psnr", mask=mask).psnr == float("inf")
    assert quadsplat.compare(picture, other, metrics="psnr",
                             mask=mask.astype(np.uint8)).psnr == float("inf")
    with pytest.raises(quadsplat.UsageError, match=r"^compare: mask has the shape \(3, 3\)"):
        quadsplat.compare(picture, other, mask=np.ones((3, 3), bool))
    with pytest.raises(quadsplat.UsageError, match="^compare: mask has elements of type float64"):
        quadsplat.compare(picture, other, mask=np.ones(other.shape[:2]))


def test_wrong_comparisons_are_refused_in_a_sentence(quadsplat):
    a = np.zeros((12, 12, 3))
    for words, sentence in [
            ((a, a[:5]), "compare: picture has the shape (5, 12, 3), but reference has (12, 12, 3)"),
            ((a[..., 0], a), "compare: reference has the shape (12, 12) instead of (any, any, 3)"),
            ((a.astype(int), a), "compare: reference has elements of type int64 instead of floats"),
            ((None, a), "compare: reference has elements of type object")]:
        with pytest.raises(quadsplat.UsageError) as raised:
            quadsplat.compare(*words)
        assert str(raised.value).startswith(sentence)
    for options, sentence in [
            ({"metrics": "dists"}, "compare: metrics: 'dists' is none of psnr, psnr_8bit, ssim"),
            ({"metrics": ()}, "compare: metrics"), ({"metrics": 3}, "compare: metrics is 3"),
            ({"ssim_border": "wrap"}, "compare: ssim_border: 'wrap' is none of 'zeros', 'crop'")]:
        with pytest.raises(quadsplat.UsageError) as raised:
            quadsplat.compare(a, a, **options)
        assert str(raised.value).startswith(sentence)
    with pytest.raises(quadsplat.UsageError, match="^compare: .*11 pixels along each side"):
        quadsplat.compare(a[:5], a[:5], ssim_border="crop")
    empty = np.zeros((0, 4, 3))
    with pytest.raises(quadsplat.UsageError, match="has no pixel"):
        quadsplat.compare(empty, empty)


def test_lpips_needs_weights(quadsplat, scene, camera, tmp_path):
    color = quadsplat.render(scene, camera).color
    with pytest.raises(quadsplat.UsageError, match="^compare: lpips_weights: is null$"):
        quadsplat.compare(color, color, metrics="lpips")
    with pytest.raises(quadsplat.InputError, match="missing.safetensors"):
        quadsplat.compare(color, color, metrics="lpips",
                          lpips_weights=tmp_path / "missing.safetensors")
