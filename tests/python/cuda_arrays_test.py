# SPDX-License-Identifier: MIT
"""Scenes and pictures of CuPy's and JAX's arrays on a GPU, against numpy's.

It is written with unittest, because scripts/check_gpu_library runs it on machines that may lack pytest.
"""
import importlib
import sys
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "python"))

import quadsplat  # noqa: E402

COUNT, WIDTH, HEIGHT = 200, 60, 40


def module(name):
    """The module, with a GPU that it can use. Raises SkipTest."""
    try:
        found = importlib.import_module(name)
        if name == "cupy":
            found.zeros(1)
        elif found.default_backend() != "gpu":
            raise RuntimeError("JAX uses no GPU")
    except Exception as error:
        raise unittest.SkipTest(f"{name}: {error}") from None
    return found


def gaussians():
    draw = np.random.default_rng(5)
    values = {"means": draw.normal(size=(COUNT, 3)) * 0.5 + [0, 0, 3], "scales": draw.random((COUNT, 3)) * 0.2 + 0.02,
              "rotations": draw.normal(size=(COUNT, 4)), "opacities": draw.random(COUNT) * 0.7 + 0.2,
              "sh": draw.normal(size=(COUNT, 4, 3)) * 0.3}
    return {name: value.astype(np.float32) for name, value in values.items()}


class Arrays:
    """The tests of a package; made(array) gives its array on the GPU."""

    def setUp(self):
        self.package = module(self.name)
        self.context = quadsplat.Context("cuda", device=0)
        self.camera = quadsplat.Camera(WIDTH, HEIGHT, 50)
        host = quadsplat.Scene.from_arrays(**gaussians(), context=self.context)
        self.expected = quadsplat.render(host, self.camera, outputs=["color", "alpha", "depth"])

    def test_a_scene_of_its_arrays_draws_the_same(self):
        given = {name: self.made(value) for name, value in gaussians().items()}
        scene = quadsplat.Scene.from_arrays(**given, context=self.context)
        found = quadsplat.render(scene, self.camera, outputs=["color", "alpha", "depth"])
        for name in ("color", "alpha", "depth"):
            self.assertTrue((getattr(found, name) == getattr(self.expected, name)).all(), name)


class CupyTest(Arrays, unittest.TestCase):
    name = "cupy"

    def made(self, array):
        return self.package.asarray(array)

    def test_pictures_are_written_into_its_arrays(self):
        scene = quadsplat.Scene.from_arrays(**gaussians(), context=self.context)
        out = {"color": self.package.zeros((HEIGHT, WIDTH, 3), self.package.float32),
               "depth": self.package.zeros((HEIGHT, WIDTH), self.package.float32)}
        places = {name: array.data.ptr for name, array in out.items()}
        stream = self.package.cuda.Stream(non_blocking=True)
        with stream:
            found = quadsplat.render(scene, self.camera, out=out)
        for name, array in out.items():
            self.assertIs(getattr(found, name), array)
            self.assertEqual(array.data.ptr, places[name])
            self.assertTrue((self.package.asnumpy(array) == getattr(self.expected, name)).all(), name)

    def test_strided_arrays_are_read_in_place(self):
        given = gaussians()
        wide = self.package.zeros((COUNT, 8), self.package.float32)
        wide[:, 2:5] = self.package.asarray(given["means"])
        arrays = {name: self.made(value) for name, value in given.items()}
        arrays["means"] = wide[:, 2:5]
        scene = quadsplat.Scene.from_arrays(**arrays, context=self.context)
        self.assertTrue((quadsplat.render(scene, self.camera).color == self.expected.color).all())


class JaxTest(Arrays, unittest.TestCase):
    name = "jax"

    def made(self, array):
        return self.package.device_put(array)

    def test_its_arrays_cannot_be_changed(self):
        scene = quadsplat.Scene.from_arrays(**gaussians(), context=self.context)
        out = {"color": self.package.numpy.zeros((HEIGHT, WIDTH, 3))}
        before = np.array(out["color"])
        try:
            quadsplat.render(scene, self.camera, out=out)
        except quadsplat.UsageError:
            self.assertTrue((np.array(out["color"]) == before).all())


if __name__ == "__main__":
    unittest.main()
