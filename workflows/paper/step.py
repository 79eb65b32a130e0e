#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs one step of the workflow in the output folder, as the rules of the Snakefile call it.

  step.py check SCENE | train SCENE SEED MODEL | eval SCENE SEED MODEL | bench SCENE SEED MODEL | zoom | collect | report
"""
import os
import pathlib
import sys

from quadsplat_paper import report, results, work
from quadsplat_paper.plan import Plan, Unit
from quadsplat_paper.problem import EXIT_OK, EXIT_USAGE, Problem

OF_A_TRAINING = {"train": work.train, "eval": work.evaluate, "bench": work.bench}


def main(words: list[str]) -> int:
    here = pathlib.Path.cwd()
    name = " ".join(words)
    try:
        plan = Plan.read(here)
        match words:
            case ["check", scene]:
                outcome = work.check(plan, scene)
            case ["train" | "eval" | "bench" as kind, scene, seed, model]:
                outcome = OF_A_TRAINING[kind](plan, Unit(scene, int(seed), model))
            case ["zoom"]:
                outcome = work.zoom(plan)
            case ["collect"]:
                outcome = results.write(plan, here)
            case ["report"]:
                outcome = report.write(plan, here)
            case _:
                print(__doc__, file=sys.stderr)
                return EXIT_USAGE
    except Problem as problem:
        print(f"paper: {name}: {problem}", file=sys.stderr, flush=True)
        # The command shows it at the end; Snakemake's own messages say less.
        failure_file(words).parent.mkdir(parents=True, exist_ok=True)
        failure_file(words).write_text(f"{name}: {problem}\n", encoding="utf-8")
        return problem.code
    failure_file(words).unlink(missing_ok=True)
    print(f"{name}: {outcome}", flush=True)
    return EXIT_OK


def failure_file(words: list[str]) -> pathlib.Path:
    return pathlib.Path("failures", "_".join(words).replace(os.sep, "_"))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
