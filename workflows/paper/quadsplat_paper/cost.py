# SPDX-License-Identifier: MIT
"""Estimates hours and gigabytes of a plan from one short training.

On an H200 an iteration took 1.55 ms per megapixel and 1.93 ms per million Gaussians (docs/training.md). A short run
measures the factor of this machine; the shares of pixels and Gaussians are assumed to stay. Expect errors of 50 %.
"""
import dataclasses
import pathlib
import shutil
import tempfile

from . import work
from .files import read_json
from .plan import Plan, Unit
from .report import PUBLISHED
from .sets import Scene

MS_PER_MEGAPIXEL, MS_PER_MILLION = 1.55, 1.93
MEAN_COUNT = 0.87           # mean number of Gaussians of a training, in units of the last
GROWTH = 16                 # Gaussians per COLMAP point at the end, as for the photographs of a doll
RANDOM_POINTS = 100_000     # train's default, for data sets without points
BYTES_PER_GAUSSIAN = 62 * 4
CHECKPOINT = 3              # a checkpoint has two moments beside the parameters
FORWARD_SHARE = 0.4         # share of an iteration; a measured frame costs about this
PROBE_ITERATIONS = 100


def expected_gaussians(scene: Scene) -> int:
    known = PUBLISHED["scenes_3dgs_gaussians"].get(scene.name) if scene.set != "Own scenes" else None
    return known or (GROWTH * scene.points if scene.points else RANDOM_POINTS)


def ms_per_iteration(scene: Scene, gaussians: float) -> float:
    """On an H200."""
    return MS_PER_MEGAPIXEL * scene.megapixels + MS_PER_MILLION * gaussians / 1e6


@dataclasses.dataclass
class Cost:
    hours: float          # hours of one GPU
    gigabytes: float      # size of all results
    peak_gigabytes: float # results and the checkpoints of the trainings at work


def estimate(plan: Plan, folder: pathlib.Path, units: list[Unit], factor: float, workers: int) -> Cost:
    """`factor`: how many times as long as the H200 this machine takes."""
    seconds = 0.0
    for unit in units:
        scene, model = plan.scene(unit.scene), plan.model(unit.model)
        count = expected_gaussians(scene)
        if not (folder / unit.folder / "done.json").is_file():
            seconds += factor * model.cost * plan.iterations * ms_per_iteration(scene, MEAN_COUNT * count) / 1e3
        frames = plan.rounds * (int(plan.frames[1]) + int(plan.frames[3])) * len(model.modes)
        views = -(-scene.views // work.HOLDOUT)
        seconds += factor * FORWARD_SHARE * ms_per_iteration(scene, count) / 1e3 * views * frames
    sizes = [expected_gaussians(plan.scene(unit.scene)) * BYTES_PER_GAUSSIAN / 1e9 for unit in units]
    extra = (CHECKPOINT + work.SAVES) * sum(sorted(sizes)[-workers:])
    return Cost(seconds / 3600 / workers, sum(sizes), sum(sizes) + extra)


def measured_factor(plan: Plan, unit: Unit) -> float:
    """Trains a few iterations of a unit in a temporary folder."""
    scene = plan.scene(unit.scene)
    with tempfile.TemporaryDirectory(prefix="quadsplat_paper_") as name:
        folder = pathlib.Path(name)
        words = [plan.program, "train", scene.data, "--out-dir", str(folder / "model"), *plan.words(unit)]
        iterations = min(PROBE_ITERATIONS, plan.iterations)
        words[words.index("--iterations") + 1] = str(iterations)
        work.require(work.run(words, folder / "log"), "the short training that measures the cost", folder / "log")
        result = (read_json(folder / "model/train.json") or {})["result"]
        ms = 1e3 * result["seconds"] / iterations
    return ms / ms_per_iteration(scene, result["gaussians"])


def free_gigabytes(folder: pathlib.Path) -> float:
    return shutil.disk_usage(folder).free / 1e9
