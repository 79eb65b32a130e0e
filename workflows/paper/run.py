#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Plans and runs the workflow. `quadsplat paper` checks its options and starts this with one argument, a JSON object."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
from typing import Any

sys.dont_write_bytecode = True
from quadsplat_paper import cost, gpus, report, work  # noqa: E402
from quadsplat_paper.files import last_line, read_json  # noqa: E402
from quadsplat_paper.plan import Plan, Unit, make_plan  # noqa: E402
from quadsplat_paper.problem import EXIT_DEVICE, EXIT_INPUT, EXIT_INTERRUPTED, EXIT_OK, EXIT_USAGE, Problem  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
ALONE = 100  # units of the resource `machine`


def say(sentence: str) -> None:
    print(sentence, flush=True)


def snakemake_version() -> int:
    """The major version. Raises Problem."""
    try:
        version = subprocess.run(["snakemake", "--version"], capture_output=True, text=True, check=True).stdout
        return int(version.split(".")[0])
    except FileNotFoundError as error:
        raise Problem("paper: snakemake was not found: install it with 'apt-get install snakemake' or 'pipx install snakemake'",
                      EXIT_DEVICE) from error
    except (OSError, ValueError, subprocess.CalledProcessError) as error:
        raise Problem(f"paper: snakemake --version failed: {error}", EXIT_DEVICE) from error


def profile_folder(name: str) -> pathlib.Path:
    folder = HERE / "profiles" / name if "/" not in name and (HERE / "profiles" / name).is_dir() else pathlib.Path(name).resolve()
    if not (folder / "config.yaml").is_file() and not any(folder.glob("config.v*.yaml")):
        raise Problem(f"--profile: {name}: is neither local nor slurm nor a folder with config.yaml", EXIT_USAGE)
    return folder


def is_cluster(profile: pathlib.Path) -> bool:
    lines = [line for file in profile.glob("config*.yaml") for line in file.read_text(encoding="utf-8").splitlines()]
    return any(line.startswith(("cluster:", "executor:")) for line in lines)


def check_earlier(plan: Plan, folder: pathlib.Path) -> None:
    """Refuses results of other options or data, and an output folder of which a data set is a part. Raises Problem."""
    for scene in plan.scenes:
        if (folder / scene.name).resolve() == pathlib.Path(scene.data).resolve():
            raise Problem(f"--out-dir: {folder}: results would be written into the data set {scene.data}", EXIT_USAGE)
        data = read_json(folder / scene.name / "data.json")
        if data and data["signature"] != work.signature(pathlib.Path(scene.data), scene.images):
            raise Problem(f"paper: {scene.data}: has changed since {folder / scene.name} was begun: use another --out-dir")
    for unit in plan.units():
        done = read_json(folder / unit.folder / "done.json")
        if not done or plan.model(unit.model).command:
            continue
        before, now = done["options"], plan.words(unit)
        if before != now:
            raise Problem(f"paper: {folder / unit.folder}: was trained with other options ('{' '.join(before)}', now "
                          f"'{' '.join(now)}'): remove this folder to train it again, or use another --out-dir")


def describe(plan: Plan) -> None:
    for scene in plan.scenes:
        say(f"{scene.name}: {scene.views} photographs, {scene.set}, {scene.data}")
    for set_name in dict.fromkeys(row["set"] for row in plan.missing):
        rows = [row for row in plan.missing if row["set"] == set_name]
        say(f"missing of {set_name}: {', '.join(row['scene'] for row in rows)}; get them from {rows[0]['source']}")
        for row in rows:
            if row["reason"] != "not found":
                say(f"  {row['scene']}: {row['reason']}")
    for row in plan.rows:
        for text in (*([row.why] if row.why else []), *row.notes):
            say(f"row {row.name}: {text}")


def agree(plan: Plan, folder: pathlib.Path, units: list[Unit], workers: int, yes: bool) -> None:
    """Prints the cost of the missing results, and asks. Raises Problem if the answer is no."""
    left = [unit for unit in units if not (folder / unit.folder / "bench/bench.json").is_file()]
    trainings = [unit for unit in units if not (folder / unit.folder / "done.json").is_file()]
    say(f"{len(units)} trainings, {len(units) - len(trainings)} of them are finished")
    own = next((unit for unit in trainings if plan.model(unit.model).command is None), None)
    if own:
        factor = cost.measured_factor(plan, own)
        price = cost.estimate(plan, folder, left, factor, workers)
        free = cost.free_gigabytes(folder)
        say(f"about {price.hours:.2g} hours with {workers} job{'s' if workers > 1 else ''} at a time, and {price.gigabytes:.2g} GB of results, "
            f"at most {price.peak_gigabytes:.2g} GB at a time ({free:.3g} GB are free)")
        if price.peak_gigabytes > free:
            say("warning: the results may not fit on this disk")
    if yes:
        return
    if not sys.stdin.isatty():
        raise Problem("paper: nobody can answer here: --yes starts without asking", EXIT_USAGE)
    if input("start? [y/N] ").strip().lower() not in ("y", "yes"):
        raise Problem("paper: not started", EXIT_INTERRUPTED)


def run_snakemake(words: list[str], folder: pathlib.Path, lock: int) -> int:
    """Runs Snakemake in a process group of its own. A signal ends the group as Ctrl+C does."""
    environment = {**os.environ, "QUADSPLAT_PAPER": str(HERE), "PYTHONDONTWRITEBYTECODE": "1"}
    with open(folder / "snakemake.log", "ab") as log:
        child = subprocess.Popen(words, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stderr=log, pass_fds=[lock],
                                 preexec_fn=os.setpgrp)
        asked = []

        def end_group(*_: Any) -> None:
            if not asked:
                asked.append(True)
                os.killpg(child.pid, signal.SIGINT)

        signal.signal(signal.SIGINT, end_group)
        signal.signal(signal.SIGTERM, end_group)
        code = child.wait()
    if asked:
        raise Problem("", EXIT_INTERRUPTED)
    return code


def failures(folder: pathlib.Path) -> list[str]:
    return [last_line(path) for path in sorted((folder / "failures").glob("*"))]


def run(request: dict[str, Any]) -> int:
    folder = pathlib.Path(request["out_dir"])
    plan = make_plan(request)
    if request["partial"]:
        if not (folder / "plan.json").is_file():
            raise Problem(f"paper: {folder}: holds no results yet")
        say(report.write_partial(plan, folder))
        return EXIT_OK
    profile, version = profile_folder(request["profile"]), snakemake_version()
    check_earlier(plan, folder)
    describe(plan)
    folder.mkdir(parents=True, exist_ok=True)
    lock = gpus.try_lock(folder / ".lock")
    if lock is None:
        raise Problem(f"paper: {folder}: another run works in this folder")
    index, count = request["shard"]
    targets = plan.targets(index, count)
    units = [*plan.units()][index - 1::count]
    cluster = is_cluster(profile)
    workers = request["jobs"] or (1 if cluster else max(1, len(plan.gpus)))
    if any(not (folder / target).is_file() for target in targets):
        agree(plan, folder, units, workers, request["yes"])
    plan.write(folder)
    shutil.rmtree(folder / "failures", ignore_errors=True)
    # The targets come first, because options of the profile take lists.
    words = ["snakemake", *(targets if count > 1 else ["tables"]), "--snakefile", str(HERE / "Snakefile"), "--profile", str(profile), "--nolock",
             *([] if cluster and not request["jobs"] else ["--jobs" if cluster else "--cores", str(workers)]),
             *([] if cluster else ["--resources", f"gpu={workers}", f"machine={ALONE}"])]
    before = report_state(folder)
    code = run_snakemake(words, folder, lock)
    if missing := [target for target in targets if not (folder / target).is_file()]:
        for sentence in failures(folder):
            say(f"failed: {sentence}")
        raise Problem(f"paper: {len(missing)} of {len(targets)} results are missing; the same line continues, --partial writes the tables of the others, and "
                      f"{folder / 'snakemake.log'} is the log")
    if code != 0:
        raise Problem(f"paper: snakemake failed: {last_line(folder / 'snakemake.log')}; {folder / 'snakemake.log'} is the log")
    if count > 1:
        say(f"shard {index}/{count} is finished: copy the folders of all shards into one, and run without --shard")
    else:
        say(f"nothing to do: {folder / 'report.md'} is up to date" if report_state(folder) == before else f"wrote {folder / 'report.md'}")
    return EXIT_OK


def report_state(folder: pathlib.Path) -> int:
    """Changes if report.md is written again."""
    path = folder / "report.md"
    return path.stat().st_mtime_ns if path.is_file() else 0


def main() -> int:
    try:
        return run(json.loads(sys.argv[1]))
    except Problem as problem:
        if str(problem):
            print(f"quadsplat: {problem}", file=sys.stderr)
        return problem.code
    except OSError as error:
        print(f"quadsplat: paper: {error.filename or 'a file'}: {error.strerror}", file=sys.stderr)
        return EXIT_INPUT
    except KeyboardInterrupt:
        return EXIT_INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
