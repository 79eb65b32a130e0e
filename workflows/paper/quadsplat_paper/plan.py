# SPDX-License-Identifier: MIT
"""The plan of a run: plan.json in the output folder, which the rules of the Snakefile and every step read."""
import dataclasses
import itertools
import json
import os
import pathlib
import shlex
from typing import Any, Iterator

from . import matrix, sets
from .files import read_json, write_json
from .problem import EXIT_USAGE, Problem
from .program import Program

NAME = "plan.json"


@dataclasses.dataclass(frozen=True)
class Unit:
    """One training with its measurements; its folder is SCENE/seedN/MODEL."""
    scene: str
    seed: int
    model: str

    @property
    def folder(self) -> str:
        return f"{self.scene}/seed{self.seed}/{self.model}"


@dataclasses.dataclass
class Plan:
    program: str
    scenes: list[sets.Scene]
    missing: list[dict[str, str]]  # scenes of the paper that are not here: set, scene, source, reason
    models: list[matrix.Model]
    rows: list[matrix.Row]
    seeds: int
    iterations: int
    train_options: list[str]
    backend: str
    pipeline: str
    frames: list[str]              # options of bench and zoom
    rounds: int
    holdout: bool                  # bench has --holdout
    lpips: str                     # weights for eval --lpips; ""
    gpus: list[str]                # numbers of the GPUs of this machine; empty: none

    # ---- contents -------------------------------------------------------------------------------

    def scene(self, name: str) -> sets.Scene:
        return next(scene for scene in self.scenes if scene.name == name)

    def model(self, name: str) -> matrix.Model:
        return next(model for model in self.models if model.name == name)

    def units(self) -> Iterator[Unit]:
        """All trainings, the first seed of all scenes first."""
        for seed, scene, model in itertools.product(range(self.seeds), self.scenes, self.models):
            if model.sets is None or scene.set in model.sets:
                yield Unit(scene.name, seed, model.name)

    def zoomed(self) -> tuple[str, str]:
        """The scene and the model of the zoom: an indoor scene as in the paper, else the first scene."""
        names = [scene.name for scene in self.scenes]
        models = [model.name for model in self.models]
        return (next((name for name in sets.ZOOMED if name in names), names[0]),
                "quadbox" if "quadbox" in models else models[0])

    def targets(self, index: int = 1, count: int = 1) -> list[str]:
        """The files of the measurements of a shard: of every `count` trainings the index-th, with its measurements."""
        files = []
        for unit in itertools.islice(self.units(), index - 1, None, count):
            files += [f"{unit.folder}/eval/eval.json", f"{unit.folder}/bench/bench.json"]
            if unit == Unit(self.zoomed()[0], 0, self.zoomed()[1]):
                files.append(f"{unit.scene}/zoom/zoom.json")
        return files

    def words(self, unit: Unit) -> list[str]:
        """The options of `train` that decide the bits of this model."""
        scene = self.scene(unit.scene)
        words = ["--images", scene.images, *self.model(unit.model).options, "--seed", str(unit.seed),
                 "--iterations", str(self.iterations), *self.train_options, "--backend", self.backend]
        return words + (["--resolution-scale", str(scene.scale)] if scene.scale > 1 else [])

    # ---- plan.json ------------------------------------------------------------------------------

    def json(self) -> dict[str, Any]:
        return json.loads(json.dumps(dataclasses.asdict(self)))  # tuples become lists, as in the file

    def write(self, folder: pathlib.Path) -> None:
        """Leaves the file as it is if nothing changed, so that no table is made again."""
        if read_json(folder / NAME) != self.json():
            write_json(folder / NAME, self.json())

    @staticmethod
    def read(folder: pathlib.Path) -> "Plan":
        content = read_json(folder / NAME)
        if content is None:
            raise Problem(f"{folder}: holds no {NAME}: start with 'quadsplat paper'")
        for key, kind in (("scenes", sets.Scene), ("models", matrix.Model), ("rows", matrix.Row)):
            content[key] = [kind(**entry) for entry in content[key]]
        return Plan(**content)


def visible_gpus(program: Program, backend: str) -> list[str]:
    if backend == "cpu":
        return []
    chosen = os.environ.get("CUDA_VISIBLE_DEVICES")
    return chosen.split(",") if chosen else [str(i) for i in range(program.gpus())]


def make_plan(request: dict[str, Any]) -> Plan:
    """The plan of the options of `quadsplat paper`. Raises Problem."""
    root, program = pathlib.Path(request["root"]), Program(request["program"])
    scenes, absent = sets.find_scenes(root, request["resolution_scale"])
    missing = [{"set": data_set.name, "scene": name, "source": data_set.source, "reason": reason}
               for data_set, name, reason in absent]
    if wanted := request["scenes"]:
        names = [scene.name for scene in scenes]
        if lost := [name for name in wanted if name not in names]:
            place = next((f"; get it from {row['source']}" for row in missing if row["scene"] == lost[0]), "")
            raise Problem(f"--scenes: {root} has no scene '{lost[0]}', but {', '.join(names) or 'none'}{place}", EXIT_USAGE)
        scenes = [scene for scene in scenes if scene.name in wanted]
        missing = [row for row in missing if row["scene"] in wanted]
    if not scenes:
        raise Problem(f"paper: {root}: holds no data set: needs folders with a COLMAP model in 'sparse' and photographs, "
                      "such as those of the paper")
    if request["lpips"] and not program.offers("eval", "--lpips"):
        raise Problem("--lpips: this program does not have 'eval --lpips'", EXIT_USAGE)
    models, rows = matrix.choose(program, request["rows"], request["methods"] and pathlib.Path(request["methods"]))
    if not models:
        raise Problem(f"paper: no row can be trained: {rows[0].name} is {rows[0].why}", EXIT_USAGE)
    try:
        train_options = shlex.split(request["train_options"])
    except ValueError as error:
        raise Problem(f"--train-options: {error}", EXIT_USAGE) from error
    return Plan(request["program"], scenes, missing, models, rows, request["seeds"], request["iterations"], train_options,
                request["backend"], request["pipeline"],
                ["--frames", str(request["frames"]), "--warmup", str(request["warmup"])], request["rounds"],
                program.offers("bench", "--holdout"), request["lpips"] or "", visible_gpus(program, request["backend"]))
