# SPDX-License-Identifier: MIT
"""The steps of the workflow, a function each. step.py calls them in the output folder.

A step may be killed at any time and started again. A training continues from its last save; the other steps begin again.
"""
import contextlib
import hashlib
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import time
from typing import Any, Iterator, Optional

from . import gpus, pictures
from .files import last_line, read_json, write_json
from .plan import Plan, Unit
from .problem import EXIT_INPUT, EXIT_INTERRUPTED, Problem
from .program import Program

SAVES = 6      # saves of a training, so that a killed one loses a sixth of its time at most
HOLDOUT = 8    # every 8th view by name is a test view
CAMERA_FILES = ("transforms.json", "cameras.json", "transforms_train.json", "transforms_test.json")


# ---- processes ----------------------------------------------------------------------------------


def run(words: list[str], log: pathlib.Path, environment: Optional[dict[str, str]] = None,
        locks: Optional[list[int]] = None) -> int:
    """Runs a program with its output in a log. Returns its exit code.

    A signal to this process also reaches the program. Ctrl+C and Slurm send their signal to both, and quadsplat ends
    immediately if the same signal comes twice; so SIGINT is passed on as SIGTERM, and SIGTERM as SIGINT.
    """
    log.parent.mkdir(parents=True, exist_ok=True)
    with open(log, "ab") as file:
        file.write(f"$ {' '.join(words)}\n".encode())
        file.flush()
        try:
            child = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=file, stderr=file, pass_fds=locks or [],
                                     env={**os.environ, **(environment or {})})
        except OSError as error:
            raise Problem(f"{words[0]} does not start: {error.strerror}") from error
        asked = []

        def pass_on(number: int, _: Any) -> None:
            if not asked:
                asked.append(number)
                child.send_signal(signal.SIGTERM if number == signal.SIGINT else signal.SIGINT)

        kept = [signal.signal(number, pass_on) for number in (signal.SIGINT, signal.SIGTERM)]
        code = child.wait()
        for number, handler in zip((signal.SIGINT, signal.SIGTERM), kept):
            signal.signal(number, handler)
    if asked:
        raise Problem(f"interrupted; {log} is the log", EXIT_INTERRUPTED)
    return code


def require(code: int, what: str, log: pathlib.Path) -> None:
    if code != 0:
        raise Problem(f"{what} failed: {last_line(log) or f'exit code {code}'}; {log} is the log", EXIT_INPUT)


def gpu_facts() -> dict[str, str]:
    """Name and driver of the first visible GPU; empty without one."""
    chosen = os.environ.get("CUDA_VISIBLE_DEVICES", "").split(",")[0]
    query = ["nvidia-smi", "--query-gpu=name,driver_version", "--format=csv,noheader", *(["-i", chosen] if chosen else [])]
    try:
        name, driver = subprocess.run(query, capture_output=True, text=True, check=True).stdout.splitlines()[0].split(", ")
    except (OSError, subprocess.CalledProcessError, ValueError, IndexError):
        return {}
    return {"gpu": name, "driver": driver}


# ---- check --------------------------------------------------------------------------------------


def data_files(data: pathlib.Path, images: str) -> list[pathlib.Path]:
    """All files of a data set that a training reads."""
    files = pictures.photographs(data / images)
    files += sorted(path for path in (data / "sparse").rglob("*") if path.is_file())
    files += [data / name for name in CAMERA_FILES if (data / name).is_file()]
    return files + sorted(path for path in (data / "masks").rglob("*") if path.is_file())


def file_hash(path: pathlib.Path) -> str:
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def signature(data: pathlib.Path, images: str) -> str:
    """Changes with names, sizes and times of the files: cheap enough for every start."""
    digest = hashlib.sha256()
    for path in data_files(data, images):
        facts = path.stat()
        digest.update(f"{path.relative_to(data)} {facts.st_size} {facts.st_mtime_ns}\n".encode())
    return digest.hexdigest()


def check(plan: Plan, scene_name: str) -> str:
    """Writes SCENE/data.json: number of photographs and hash of all files."""
    scene = plan.scene(scene_name)
    data = pathlib.Path(scene.data)
    if not pictures.photographs(data / scene.images):
        raise Problem(f"{data / scene.images}: holds no photographs")
    digest = hashlib.sha256()
    for path in data_files(data, scene.images):
        digest.update(f"{path.relative_to(data)} {file_hash(path)}\n".encode())
    write_json(pathlib.Path(scene_name, "data.json"),
               {"scene": scene_name, "photographs": scene.views, "points": scene.points, "hash": f"sha256:{digest.hexdigest()}",
                "signature": signature(data, scene.images)})
    return f"{scene.views} photographs"


# ---- train --------------------------------------------------------------------------------------


def finished(model: pathlib.Path, iterations: int) -> Optional[dict[str, Any]]:
    """train.json of a finished run, else None."""
    report = read_json(model / "train.json")
    good = report is not None and report.get("result", {}).get("iteration", 0) >= iterations
    return report if good and (model / "point_cloud").is_dir() else None


def remove_leftovers(model: pathlib.Path, iterations: int) -> None:
    """Removes the checkpoint and the earlier iterations, which only a broken run needs."""
    (model / "checkpoint").unlink(missing_ok=True)
    for saved in (model / "point_cloud").glob("iteration_*"):
        if saved.name != f"iteration_{iterations}":
            shutil.rmtree(saved, ignore_errors=True)


def folder_bytes(folder: pathlib.Path) -> int:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def train_words(plan: Plan, unit: Unit, model: pathlib.Path) -> list[str]:
    """The command line that begins or continues the training."""
    words = [plan.program, "train", plan.scene(unit.scene).data, "--out-dir", str(model), *plan.words(unit),
             "--save-every", str(max(1, -(-plan.iterations // SAVES)))]
    if (model / "checkpoint").is_file():
        words.append("--resume")
    elif model.is_dir() and any(model.iterdir()):
        words.append("--overwrite")
    return words


def command_words(plan: Plan, unit: Unit, model: pathlib.Path) -> list[str]:
    """The words of a method's own command with the names in braces replaced."""
    scene = plan.scene(unit.scene)
    values = {"program": plan.program, "data": scene.data, "images": scene.images, "out": str(model.resolve()),
              "seed": str(unit.seed), "iterations": str(plan.iterations), "scale": str(scene.scale)}
    words = plan.model(unit.model).command or []
    for name, value in values.items():
        words = [word.replace(f"{{{name}}}", value) for word in words]
    return words


def gaussians_of(plan: Plan, model: pathlib.Path) -> int:
    done = subprocess.run([plan.program, "info", "--json", "-", str(model)], capture_output=True, text=True)
    if done.returncode != 0:
        raise Problem(f"{model}: {done.stderr.strip().splitlines()[-1] if done.stderr.strip() else 'is no model'}")
    return json.loads(done.stdout)[0]["gaussians"]


def train(plan: Plan, unit: Unit) -> str:
    """Writes done.json once the model is finished. The model folder is locked while any process works in it."""
    folder = pathlib.Path(unit.folder)
    model, log = folder / "model", folder / "train.log"
    own = plan.model(unit.model).command is not None
    with gpus.locked(folder / "lock") as lock:
        begin, began_at, attempts = time.monotonic(), time.time(), 0
        environment: dict[str, str] = {}
        if own or not finished(model, plan.iterations):
            with gpus.one_gpu(plan.gpus) as (environment, gpu):
                words = command_words(plan, unit, model) if own else train_words(plan, unit, model)
                require(run(words, log, environment, [lock, *gpu]), "training", log)
        report = read_json(model / "train.json") if own else finished(model, plan.iterations)
        if report is None and not own:
            raise Problem(f"training ended without a finished model in {model}; {log} is the log")
        if not own:
            remove_leftovers(model, plan.iterations)
        attempts = sum(line.startswith("$ ") for line in log.read_text(errors="replace").splitlines()) if log.is_file() else 0
        result = report.get("result", {}) if report else {}
        wall = time.monotonic() - begin
        count = result.get("gaussians") or gaussians_of(plan, model)
        seconds = result.get("seconds", wall)
        write_json(folder / "done.json", {
            "scene": unit.scene, "seed": unit.seed, "model": unit.model,
            "options": command_words(plan, unit, model) if own else plan.words(unit),
            "settings": report.get("settings", {}) if report else {}, "gaussians": count, "seconds": seconds,
            "attempts": attempts, "bytes": folder_bytes(model), **provenance(plan, environment, report),
            "data": (read_json(pathlib.Path(unit.scene, "data.json")) or {}).get("hash"), "finished": int(began_at + wall)})
    return f"trained, {count:,} Gaussians, {seconds:.1f} s"


def provenance(plan: Plan, environment: dict[str, str], report: Optional[dict[str, Any]]) -> dict[str, Any]:
    """Program, commit and machine of a result."""
    there = (report or {}).get("environment", {})
    with chosen_gpu(environment):
        on_gpu = gpu_facts() if there.get("backend") != "cpu" else {}
    return {"program": plan.program, "version": there.get("version"), "commit": there.get("commit") or Program(plan.program).commit(),
            "backend": there.get("backend"), "gpu": there.get("gpu") or on_gpu.get("gpu"), "driver": on_gpu.get("driver"),
            "cpu": there.get("cpu"), "host": socket.gethostname(), "slurm_job": os.environ.get("SLURM_JOB_ID"),
            "visible_gpus": environment.get("CUDA_VISIBLE_DEVICES", os.environ.get("CUDA_VISIBLE_DEVICES"))}


@contextlib.contextmanager
def chosen_gpu(environment: dict[str, str]) -> Iterator[None]:
    kept = os.environ.get("CUDA_VISIBLE_DEVICES")
    os.environ.update(environment)
    try:
        yield
    finally:
        if environment and kept is None:
            del os.environ["CUDA_VISIBLE_DEVICES"]
        elif environment:
            os.environ["CUDA_VISIBLE_DEVICES"] = str(kept)


# ---- measurements -------------------------------------------------------------------------------


def measure(plan: Plan, words: list[str], log: pathlib.Path, what: str) -> None:
    with gpus.one_gpu(plan.gpus) as (environment, gpu):
        require(run([plan.program, *words, "--backend", plan.backend, "--overwrite"], log, environment, gpu), what, log)


def row_modes(plan: Plan, model: str) -> list[str]:
    """The modes in which a model's quality is needed; a plugin draws none."""
    rows = [row for row in plan.rows if row.model == model and not row.why and row.mode in program_modes(plan)]
    return [*dict.fromkeys(row.mode for row in rows)] or ["quadbox"]


def program_modes(plan: Plan) -> list[str]:
    return [mode for model in plan.models for mode in model.modes]


def evaluate(plan: Plan, unit: Unit) -> str:
    """Writes eval/, and the crops of the paper's figure for the first seed."""
    folder, scene = pathlib.Path(unit.folder), plan.scene(unit.scene)
    log, shown = folder / "eval.log", folder / "shown"
    words = ["eval", str(folder / "model"), "--images", str(pathlib.Path(scene.data, scene.images)), "--holdout", str(HOLDOUT),
             "--images-scale", str(scene.scale), "--cull", ",".join(row_modes(plan, unit.model)), "--out-dir", str(folder / "eval")]
    words += ["--lpips", plan.lpips] if plan.lpips else []
    words += ["--exact-color"] if "--color-field" in plan.model(unit.model).options else []
    cropped = scene.crop if unit.seed == 0 else None
    shutil.rmtree(shown, ignore_errors=True)
    measure(plan, words + (["--save", str(shown), "--save-format", "ppm"] if cropped else []), log, "eval")
    report = read_json(folder / "eval/eval.json")
    if cropped and report:
        names = [*dict.fromkeys(view["name"] for view in report["views"])]
        name = pathlib.Path(names[min(cropped[0], len(names) - 1)]).name
        part = tuple(value // scene.scale for value in cropped[1:])
        for picture in shown.glob(f"view_*{name}_*.ppm"):
            what = picture.stem.rsplit("_", 1)[1]
            pictures.crop_ppm(picture, folder / "crops" / f"{what}.png", (part[0], part[1], part[2], part[3]))
    shutil.rmtree(shown, ignore_errors=True)
    means = report["means"] if report else []
    return "; ".join(f"{mean['mode']} {mean['psnr'] if mean['psnr'] is not None else float('inf'):.2f} dB" for mean in means)


def test_cameras(model: pathlib.Path) -> list[int]:
    """The places of the test views in the model's cameras.json."""
    cameras = read_json(model / "cameras.json")
    if not cameras:
        raise Problem(f"{model}: has no cameras.json")
    by_name = sorted(range(len(cameras)), key=lambda i: cameras[i]["img_name"])
    return sorted(by_name[::HOLDOUT])


def bench(plan: Plan, unit: Unit) -> str:
    """Writes bench/: the modes in turns, on the test views. Snakemake runs it alone on its machine."""
    folder, model = pathlib.Path(unit.folder), plan.model(unit.model)
    views = ["--holdout", str(HOLDOUT)] if plan.holdout else \
        ["--camera-index", ",".join(map(str, test_cameras(folder / "model")))]
    words = ["bench", str(folder / "model"), *views, "--cull", ",".join(model.modes), *plan.frames,
             "--rounds", str(plan.rounds), "--pipeline", plan.pipeline, "--out-dir", str(folder / "bench")]
    words += ["--plugin", model.plugin] if model.plugin else []
    measure(plan, words, folder / "bench.log", "bench")
    return f"measured {', '.join(model.modes)}"


def zoom(plan: Plan) -> str:
    """Writes SCENE/zoom: the paper's first figure."""
    scene, model = plan.zoomed()
    folder = pathlib.Path(Unit(scene, 0, model).folder, "model")
    measure(plan, ["zoom", str(folder), "--from-camera", str(test_cameras(folder)[0]), *plan.frames, "--pipeline", plan.pipeline,
                   "--cull", ",".join(plan.model(model).modes), "--out-dir", f"{scene}/zoom"],
            pathlib.Path(scene, "zoom.log"), "zoom")
    return f"measured {scene}"
