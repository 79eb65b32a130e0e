# SPDX-License-Identifier: MIT
"""Runs a trainer for drop_in_times and measures it: drop_in_kit.py JSON TRAINER ARGUMENTS. The trainer's files do not change.

JSON has report (a file), iterations, seed, and profile: null, or [first, last] iterations of a profile by torch.
Both trainers of a pair run through this file. Modules that do not take part in training have stand-ins here: tyro, viser, nerfview,
piexif, pycolmap (a reader of COLMAP's binary files) and LPIPS of torchmetrics, which would download its weights.
"""
import collections
import json
import os
import runpy
import struct
import sys
import tempfile
import time
import types

TIMED_BEFORE_PROFILE = 100  # iterations whose time a profile gives beside its own


def module(name, **names):
    made = types.ModuleType(name)
    vars(made).update(names)
    sys.modules[name] = made


def command_line(configs):
    """tyro.extras.overridable_config_cli: NAME, then --field VALUE, where a field of a field is a.b and a flag has no value."""
    config, words = configs[sys.argv[1]][1], sys.argv[2:]
    while words:
        *path, name = words.pop(0)[2:].replace("-", "_").split(".")
        owner = config
        for part in path:
            owner = getattr(owner, part)
        old = getattr(owner, name)
        if isinstance(old, bool):
            value = True
        elif isinstance(old, list):
            value = []
            while words and not words[0].startswith("--"):
                value.append(int(words.pop(0)))
        else:
            value = type(old)(words.pop(0))
        setattr(owner, name, value)
    return config


class Reader:
    def __init__(self, file):
        with open(file, "rb") as opened:
            self.content, self.at = opened.read(), 0

    def __call__(self, form):
        values = struct.unpack_from("<" + form, self.content, self.at)
        self.at += struct.calcsize("<" + form)
        return values

    def skip(self, count):
        self.at += count

    def string(self):
        end = self.content.index(b"\0", self.at)
        value, self.at = self.content[self.at:end].decode(), end + 1
        return value


class Reconstruction:
    """pycolmap.Reconstruction with the members that gsplat's parser reads; tracks are empty."""

    def __init__(self, folder):
        import numpy as np  # pylint: disable=import-outside-toplevel
        self.cameras, self.images, self.points3D = {}, {}, {}
        read = Reader(os.path.join(folder, "cameras.bin"))
        for _ in range(read("Q")[0]):
            number, model, width, height = read("IiQQ")
            if model != 1:
                sys.exit(f"drop_in_kit: camera {number} is not a PINHOLE camera")
            params = read("4d")
            matrix = np.array([[params[0], 0, params[2]], [0, params[1], params[3]], [0, 0, 1]])
            self.cameras[number] = types.SimpleNamespace(model_name="PINHOLE", params=params, width=width, height=height,
                                                         calibration_matrix=lambda matrix=matrix: matrix)
        read = Reader(os.path.join(folder, "images.bin"))
        for _ in range(read("Q")[0]):
            number, w, x, y, z, *place, camera = read("I7dI")
            matrix = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), place[0]],
                               [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), place[1]],
                               [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), place[2]]])
            pose = types.SimpleNamespace(matrix=lambda matrix=matrix: matrix)
            self.images[number] = types.SimpleNamespace(name=read.string(), camera_id=camera, cam_from_world=pose)
            read.skip(24 * read("Q")[0])
        read = Reader(os.path.join(folder, "points3D.bin"))
        track = types.SimpleNamespace(elements=[])
        for _ in range(read("Q")[0]):
            number, *place, r, g, b, error, length = read("Q3d3BdQ")
            read.skip(8 * length)
            self.points3D[number] = types.SimpleNamespace(xyz=place, color=(r, g, b), error=error, track=track)

    def reg_image_ids(self):
        return list(self.images)


def add_stand_ins():
    class InvalidImageDataError(ValueError):
        pass

    def no_exif(_):
        raise InvalidImageDataError

    extras = types.SimpleNamespace(overridable_config_cli=command_line)
    module("tyro", extras=extras)
    module("viser", ViserServer=object)
    module("nerfview", Viewer=object, RenderTabState=object, CameraState=object, apply_float_colormap=None)
    module("piexif", load=no_exif, InvalidImageDataError=InvalidImageDataError)
    module("pycolmap", Reconstruction=Reconstruction)


def replace_lpips(torch):
    import torchmetrics.image.lpip as lpip  # pylint: disable=import-outside-toplevel

    class NoLpips(torch.nn.Module):
        def __init__(self, **_):
            super().__init__()

        def forward(self, a, _):
            return a.new_zeros(())

    lpip.LearnedPerceptualImagePatchSimilarity = NoLpips


def shift_seeds(torch, seed):
    """Adds a number to each seed that the trainer sets."""
    import random  # pylint: disable=import-outside-toplevel

    import numpy  # pylint: disable=import-outside-toplevel
    for owner, name in ((random, "seed"), (numpy.random, "seed"), (torch, "manual_seed")):
        def shifted(value, *rest, set_seed=getattr(owner, name)):
            return set_seed((value + seed) % 2**32 if isinstance(value, int) else value, *rest)
        setattr(owner, name, shifted)


class Measure:
    """Counts the calls of backward(), one an iteration, and takes times: from the progress bar to the last call and its wait."""

    def __init__(self, torch, options):
        self.torch, self.options, self.count, self.start, self.found = torch, options, 0, None, {}
        self.first, self.last = options["profile"] or (0, 0)
        self.profile = self.before = None
        self.plain_backward = torch.Tensor.backward
        own = self

        def backward(tensor, *arguments, **named):
            own.plain_backward(tensor, *arguments, **named)
            own.counted()
        torch.Tensor.backward = backward
        import tqdm  # pylint: disable=import-outside-toplevel
        plain_init = tqdm.std.tqdm.__init__

        def init(bar, *arguments, **named):
            plain_init(bar, *arguments, **named)
            if bar.total == options["iterations"] and own.start is None:
                own.start = own.now()
        tqdm.std.tqdm.__init__ = init

    def now(self):
        if self.torch.cuda.is_available():
            self.torch.cuda.synchronize()
        return time.perf_counter()

    def counted(self):
        self.count += 1
        if self.count == 1 and self.start is None:
            self.start = self.now()
        if self.count in (1, 10, 100) or self.count % 500 == 0:
            self.found.setdefault("seconds_at", {})[self.count] = round(time.perf_counter() - self.start, 3)
        if self.last:
            if self.count == self.first - TIMED_BEFORE_PROFILE:
                self.before = self.now()
            elif self.count == self.first:
                self.before = (self.now() - self.before) / TIMED_BEFORE_PROFILE
                self.memory = self.torch.cuda.memory_stats() if self.torch.cuda.is_available() else {}
                self.profile = self.torch.profiler.profile()
                self.profile.start()
                self.begin = self.now()
            elif self.count == self.last:
                wall = self.now() - self.begin
                self.profile.stop()
                self.found["profile"] = self.summary(wall)
        if self.count == self.options["iterations"]:
            self.found["loop_s"] = self.now() - self.start
            if self.torch.cuda.is_available():
                self.found["torch_gib"] = self.torch.cuda.max_memory_allocated() / 2**30
                self.found["reserved_gib"] = self.torch.cuda.max_memory_reserved() / 2**30

    def summary(self, wall):
        """Numbers of an iteration, from the trace that the profiler writes."""
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "trace.json")
            self.profile.export_chrome_trace(file)
            with open(file, encoding="utf-8") as opened:
                events = json.load(opened)
        events = events["traceEvents"] if isinstance(events, dict) else events
        turns = self.last - self.first
        kernels, calls = collections.defaultdict(lambda: [0, 0.0]), collections.defaultdict(lambda: [0, 0.0])
        operators = collections.defaultdict(lambda: [0, 0.0])
        groups = {"kernel": kernels, "gpu_memcpy": kernels, "gpu_memset": kernels, "cuda_runtime": calls, "cuda_driver": calls,
                  "cpu_op": operators}
        busy, copies = 0.0, 0
        for event in events:
            kind = event.get("cat")
            if event.get("ph") != "X" or kind not in groups:
                continue
            entry = groups[kind][event["name"]]
            entry[0] += 1
            entry[1] += event["dur"]
            if groups[kind] is kernels:
                busy += event["dur"]
                copies += kind != "kernel"
        memory = self.torch.cuda.memory_stats() if self.torch.cuda.is_available() else {}
        waits = sum(micros for name, (_, micros) in calls.items() if "Synchronize" in name) / 1e3 / turns
        rows = {"ms without the profiler": 1e3 * self.before, "ms with the profiler": 1e3 * wall / turns,
                "of these the host waits in synchronisations": waits, "the host works": 1e3 * wall / turns - waits,
                "GPU busy, ms": busy / 1e3 / turns, "kernels": sum(n for n, _ in kernels.values()) / turns - copies / turns,
                "copies and fills on the GPU": copies / turns, "operators of torch": sum(n for n, _ in operators.values()) / turns,
                "calls of CUDA": sum(n for n, _ in calls.values()) / turns, "ms in calls of CUDA": sum(t for _, t in calls.values()) / 1e3 / turns,
                "allocations from torch": self.grown(memory, "allocation.all.allocated") / turns,
                "segments that torch asked for": self.grown(memory, "segment.all.allocated") / turns}
        for name in ("cudaLaunchKernel", "cudaMemcpyAsync", "cudaMemcpy", "cudaMemsetAsync", "cudaStreamSynchronize",
                     "cudaDeviceSynchronize", "cudaEventSynchronize", "cudaMalloc", "cudaFree", "cudaMallocAsync", "cudaFreeAsync",
                     "cudaHostAlloc", "cudaGraphLaunch"):
            number = sum(n for key, (n, _) in calls.items() if key.split("_v")[0] == name) / turns
            if number:
                rows[name] = number

        def ordered(group, by):
            pairs = sorted(group.items(), key=lambda pair: -pair[1][by])[:20]
            return [[name[:100], n / turns, t / turns] for name, (n, t) in pairs]
        return {"rows": rows, "kernels": ordered(kernels, 1), "calls": ordered(calls, 1), "operators": ordered(operators, 0)}

    def grown(self, memory, key):
        return memory.get(key, 0) - self.memory.get(key, 0)


def main():
    options, trainer = json.loads(sys.argv[1]), sys.argv[2]
    begin = time.perf_counter()
    add_stand_ins()
    import torch  # pylint: disable=import-outside-toplevel
    if os.path.basename(trainer) == "simple_trainer.py":
        replace_lpips(torch)
    shift_seeds(torch, options["seed"])
    measure = Measure(torch, options)
    sys.argv = sys.argv[2:]
    sys.path[0] = os.path.dirname(os.path.abspath(trainer))
    try:
        runpy.run_path(trainer, run_name="__main__")
    finally:
        measure.found.update(iterations=measure.count, process_s=time.perf_counter() - begin)
        with open(options["report"], "w", encoding="utf-8") as file:
            json.dump(measure.found, file, indent=1)


if __name__ == "__main__":
    main()
