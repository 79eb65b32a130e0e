# SPDX-License-Identifier: MIT
"""Collects the results of all steps: rows.csv and rows.json, a row per scene, seed and row of the tables."""
import pathlib
import statistics
from typing import Any, Optional

from .files import read_json, write_csv, write_json
from .plan import Plan, Unit

COLUMNS = ["set", "scene", "seed", "row", "state", "psnr", "ssim", "lpips_paper", "lpips", "gaussians", "pairs", "train_seconds",
           "fps_paper", "ms_median", "model", "mode", "attempts", "model_bytes", "data", "backend", "pipeline", "bench_frames",
           "bench_rounds", "version", "commit", "gpu", "driver", "cpu", "host", "visible_gpus", "slurm_job", "why"]
TIMES = {"train_seconds", "fps_paper", "ms_median"}


def collect(plan: Plan, folder: pathlib.Path) -> list[dict[str, Any]]:
    """All rows of the tables. `state`: done, missing, or unavailable, which `why` explains."""
    rows = []
    wanted = {unit.folder for unit in plan.units()}
    for scene in plan.scenes:
        for seed in range(plan.seeds):
            for row in plan.rows:
                unit = Unit(scene.name, seed, row.model)
                base = {"set": scene.set, "scene": scene.name, "seed": seed, "row": row.name, "model": row.model, "mode": row.mode}
                if row.why:
                    rows.append({**base, "state": "unavailable", "why": row.why})
                elif unit.folder in wanted:
                    rows.append({**base, **measured(folder / unit.folder, row.mode)})
    return rows


def measured(folder: pathlib.Path, mode: str) -> dict[str, Any]:
    done, quality, times = (read_json(folder / name) for name in ("done.json", "eval/eval.json", "bench/bench.json"))
    result: dict[str, Any] = {"state": "done" if done and quality and times else "missing"}
    if done:
        result |= {"gaussians": done["gaussians"], "train_seconds": done["seconds"], "model_bytes": done["bytes"]}
        result |= {name: done.get(name) for name in ("attempts", "data", "backend", "version", "commit", "gpu", "driver", "cpu",
                                                     "host", "visible_gpus", "slurm_job")}
    if quality:
        result |= quality_of(quality, mode)
    if times:
        listed = [entry for entry in times.get("fps_paper", []) if entry["mode"] == mode and entry["scene"] is not None]
        result |= speed_of([row for row in times["rows"] if row["mode"] == mode], listed[0]["fps"] if listed else None)
        result |= {"pipeline": times["environment"].get("pipeline"), "bench_frames": times["environment"].get("frames"),
                   "bench_rounds": times["environment"].get("rounds")}
    return result


def quality_of(report: dict[str, Any], mode: str) -> dict[str, Optional[float]]:
    """The means of a mode over the test views; PSNR is None if it is infinite or the mode was not evaluated."""
    mean = next((mean for mean in report["means"] if mean["mode"] == mode), {})
    return {name: mean.get(name) for name in ("psnr", "ssim", "lpips_paper", "lpips")}


def speed_of(rows: list[dict[str, Any]], measured_as_published: Optional[float] = None) -> dict[str, float]:
    """`fps_paper` averages times, as the paper does: 1000 / mean milliseconds of the views.

    `bench --holdout` measures it as the published script does; an older program gives the mean of its timed frames.
    """
    if not rows:
        return {}
    mean = statistics.fmean(row["ms_mean"] for row in rows)
    return {"fps_paper": measured_as_published or 1000 / mean, "ms_median": statistics.fmean(row["ms_median"] for row in rows),
            "pairs": sum(row["pairs"] for row in rows)}


def write(plan: Plan, folder: pathlib.Path) -> str:
    rows = collect(plan, folder)
    write_csv(folder / "rows.csv", COLUMNS, rows)
    write_json(folder / "rows.json", rows)
    done = sum(row["state"] == "done" for row in rows)
    return f"{done} of {len(rows)} rows are measured"
