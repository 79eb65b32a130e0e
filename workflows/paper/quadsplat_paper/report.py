# SPDX-License-Identifier: MIT
"""Writes report.md: the paper's tables with our numbers beside the printed ones, ratios, plots, crops, and what is missing.

A chapter is a function of Tables that yields lines. To add one: the function, and its name in CHAPTERS.
"""
import json
import pathlib
import statistics
from typing import Any, Callable, Iterable, Iterator, Optional

from . import charts, ratios, results
from .files import read_json, write_text
from .plan import Plan, Unit

PUBLISHED = json.loads(pathlib.Path(__file__).with_name("published.json").read_text(encoding="utf-8"))
NONE = "-"
NOISE = 0.03  # the same value as in docs/benchmarking.md
FORMATS: dict[str, Callable[[float], str]] = {
    "psnr": lambda v: f"{v:.2f}", "ssim": lambda v: f"{v:.4f}", "lpips_paper": lambda v: f"{v:.4f}", "lpips": lambda v: f"{v:.4f}",
    "gaussians": lambda v: f"{v / 1e6:.3f} M" if v >= 1e5 else f"{v:,.0f}", "train_seconds": lambda v: f"{v:,.1f}",
    "fps_paper": lambda v: f"{v:,.1f}"}
HEADS = {"psnr": "PSNR dB", "ssim": "SSIM", "lpips_paper": "LPIPS (paper)", "lpips": "LPIPS", "gaussians": "Gaussians",
         "fps_paper": "FPS (paper)", "train_seconds": "training s"}
ABLATION = ("3dgs", "adr", "dualbox", "quadbox-naive", "quadbox")


def table(head: list[str], rows: Iterable[list[str]]) -> Iterator[str]:
    yield "| " + " | ".join(head) + " |"
    yield "|" + "---|" * len(head)
    for row in rows:
        yield "| " + " | ".join(row) + " |"
    yield ""


class Tables:
    """The collected rows, with the means that tables show."""

    def __init__(self, plan: Plan, folder: pathlib.Path):
        self.plan, self.folder = plan, folder
        self.rows = read_json(folder / "rows.json") or []
        self.sets = [*dict.fromkeys(scene.set for scene in plan.scenes)]

    def values(self, quantity: str, row: str, scene: str) -> list[float]:
        """One value per seed."""
        return [entry[quantity] for entry in self.rows
                if (entry["row"], entry["scene"]) == (row, scene) and entry.get(quantity) is not None]

    def scenes(self, set_name: str) -> list[str]:
        return [scene.name for scene in self.plan.scenes if scene.set == set_name]

    def mean(self, quantity: str, row: str, set_name: str) -> tuple[Optional[float], int]:
        """The arithmetic mean over scenes of the means over seeds, and the number of scenes that have a value."""
        means = [statistics.fmean(values) for scene in self.scenes(set_name) if (values := self.values(quantity, row, scene))]
        return (statistics.fmean(means) if means else None), len(means)

    def whole_mean(self, quantity: str, row: str, set_name: str) -> Optional[float]:
        """The same mean; None unless all scenes of the set have a value, because means over other scenes cannot be compared."""
        value, count = self.mean(quantity, row, set_name)
        return value if count == len(self.scenes(set_name)) else None

    def seed_means(self, quantity: str, row: str, set_name: str) -> list[float]:
        """The mean over scenes for every seed that measured all scenes."""
        scenes, means = self.scenes(set_name), []
        for seed in range(self.plan.seeds):
            values = [entry[quantity] for entry in self.rows if entry["row"] == row and entry["seed"] == seed and
                      entry["set"] == set_name and entry.get(quantity) is not None]
            if len(values) == len(scenes):
                means.append(statistics.fmean(values))
        return means

    def has(self, quantity: str) -> bool:
        return any(entry.get(quantity) is not None for entry in self.rows)

    def shown(self, set_name: str) -> list[Any]:
        """The rows of a set: those that were planned for it."""
        names = {entry["row"] for entry in self.rows if entry["set"] == set_name}
        return [row for row in self.plan.rows if row.name in names]

    def bench(self, scene: str, seed: int, model: str) -> list[dict[str, Any]]:
        report = read_json(self.folder / Unit(scene, seed, model).folder / "bench/bench.json")
        return report["rows"] if report else []

    def different(self, key: str) -> list[str]:
        return [*dict.fromkeys(str(entry[key]) for entry in self.rows if entry.get(key) not in (None, ""))]

    @property
    def on_gpu(self) -> bool:
        return any(backend.startswith("cuda") for backend in self.different("backend"))  # "cuda, NAME OF THE GPU"


def printed(quantity: str, row: str, set_name: str) -> Optional[float]:
    entry = next((entry for entry in PUBLISHED["values"] if (entry["set"], entry["row"], entry["quantity"]) ==
                  (set_name, row, quantity)), None)
    return entry and entry["value"] * (1e6 if quantity == "gaussians" else 1)


def cell(quantity: str, value: Optional[float]) -> str:
    return NONE if value is None else FORMATS[quantity](value)


# ---- chapters -----------------------------------------------------------------------------------


def facts(tables: Tables) -> Iterator[str]:
    plan = tables.plan
    measured = sum(entry["state"] == "done" for entry in tables.rows)
    yield f"{measured} of {len(tables.rows)} rows are measured: {len(plan.scenes)} scene{'s' if len(plan.scenes) > 1 else ''}, " \
          f"{plan.seeds} seed{'s' if plan.seeds > 1 else ''}, {plan.iterations:,} iterations" + \
          (f", further options of train: `{' '.join(plan.train_options)}`" if plan.train_options else "") + "."
    devices = tables.different("gpu") if tables.on_gpu else tables.different("cpu")
    yield f"Measured on: {', '.join(devices) or 'unknown'} (backend {', '.join(tables.different('backend')) or 'unknown'}, pipeline " \
          f"{', '.join(tables.different('pipeline')) or plan.pipeline}); commit {', '.join(tables.different('commit')) or 'unknown'}; " \
          f"{', '.join(tables.different('bench_frames'))} frames and {', '.join(tables.different('bench_rounds'))} rounds per view."
    rows = [row for unit in plan.units() for row in tables.bench(unit.scene, unit.seed, unit.model)]
    noisy = sum(max(abs(row["drift"]), row["round_spread"] or 0) > NOISE for row in rows)
    yield f"Pictures of {', '.join(dict.fromkeys('{width} x {height}'.format(**row) for row in rows)) or 'unknown size'}. " \
          f"{noisy} of {len(rows)} measurements of a mode in a view are noisy: drift or spread of the rounds above {100 * NOISE:.0f} %."
    if not tables.on_gpu:
        yield "**These numbers were measured on the CPU.** Times of a CPU cannot be compared with the paper's; quality and numbers " \
              "of Gaussians can, up to the rounding of exponentials."
    if len(devices) > 1:
        yield "Several devices measured these rows, so FPS of different rows cannot be compared."
    if len(tables.different("commit")) > 1:
        yield "Several versions of the program made these rows."
    yield ""


def table_1(tables: Tables) -> Iterator[str]:
    yield "## Table 1: quality, size and speed\n"
    yield "Means over scenes of the means over seeds. `FPS (paper)` is 1000 / mean milliseconds of the test views, averaged over scenes " \
          "as in the paper. *printed* is the paper's number, where our notes have it.\n"
    quantities = [name for name in HEADS if name not in ("lpips", "lpips_paper") or tables.has(name)]
    for set_name in tables.sets:
        rows = tables.shown(set_name)
        compared = [q for q in quantities if any(printed(q, row.name, set_name) is not None for row in rows)]
        head = ["row", *(text for q in quantities for text in ([HEADS[q], "printed"] if q in compared else [HEADS[q]]))]
        lines = []
        for row in rows:
            line = [row.title]
            for quantity in quantities:
                value, count = tables.mean(quantity, row.name, set_name)
                part = f" ({count} of {len(tables.scenes(set_name))} scenes)" if 0 < count < len(tables.scenes(set_name)) else ""
                line.append(cell(quantity, value) + part)
                if quantity in compared:
                    line.append(cell(quantity, printed(quantity, row.name, set_name)))
            lines.append(line)
        yield f"### {set_name}\n"
        yield from table(head, lines)
    notes = [f"- {row.title}: {text}" for row in tables.plan.rows for text in (*([row.why] if row.why else []), *row.notes)]
    yield from [*notes, ""] if notes else []


def table_2(tables: Tables) -> Iterator[str]:
    yield "## Table 2: FPS (paper) of every scene\n"
    rows = [row for row in tables.plan.rows if not row.why]
    yield from table(["scene", *(row.title for row in rows)],
                     [[scene.name, *(cell("fps_paper", statistics.fmean(values) if (values := tables.values("fps_paper", row.name, scene.name))
                                          else None) for row in rows)] for scene in tables.plan.scenes])
    yield "The paper prints AdR and QuadBox on nine scenes, with means of 302.4 and 321.7 FPS.\n"


def table_3(tables: Tables) -> Iterator[str]:
    yield "## Table 3: the ablation\n"
    yield "The paper's FPS are of an RTX 4090. It trained every row; here `adr`, `quadbox-naive` and `quadbox` share a model, because lossless " \
          "modes train equal models.\n"
    fps = {entry["row"]: entry["fps"] for entry in PUBLISHED["ablation"]}
    for set_name in [name for name in tables.sets if name in ("Mip-NeRF 360", "Own scenes")]:
        rows = [row for row in tables.shown(set_name) if row.name in ABLATION]
        yield f"### {set_name}\n"
        yield from table(["row", "FPS (paper)", "printed", *(HEADS[q] for q in ("psnr", "ssim", "gaussians"))],
                         [[row.title, cell("fps_paper", tables.mean("fps_paper", row.name, set_name)[0]), str(fps[row.name]),
                           *(cell(q, tables.mean(q, row.name, set_name)[0]) for q in ("psnr", "ssim", "gaussians"))] for row in rows])


def own_model_ratio(tables: Tables, claim: dict[str, Any], set_name: str) -> Optional[ratios.Ratio]:
    """As the paper: each row on its own model, FPS averaged over scenes. Seeds are the samples."""
    both = [tables.seed_means("fps_paper", name, set_name) for name in (claim["row"], claim["baseline"])]
    logs = [ratios.math.log(a / b) for a, b in zip(*both)]
    return ratios.mean_of([ratios.sample_of(logs)]) if logs else None


def one_model_ratio(tables: Tables, claim: dict[str, Any], set_name: str) -> Optional[ratios.Ratio]:
    """Both modes on the model of the claim's row, in turns; cameras are the samples."""
    rows = {row.name: row for row in tables.plan.rows}
    if not {claim["row"], claim["baseline"]} <= set(rows):
        return None
    row, other = rows[claim["row"]], rows[claim["baseline"]]
    found = [ratios.paired(tables.bench(scene, seed, row.model), row.mode, other.mode)
             for scene in tables.scenes(set_name) for seed in range(tables.plan.seeds)]
    samples = [sample for sample in found if sample]
    return ratios.mean_of(samples) if samples else None


def ratio_text(ratio: Optional[ratios.Ratio]) -> str:
    if ratio is None:
        return NONE
    return f"{ratio.value:.3f}" + ("" if ratio.low is None else f" [{ratio.low:.3f}, {ratio.high:.3f}]")


def verdict(ratio: ratios.Ratio, low: float, high: float) -> str:
    """Compares the interval, or the value without one, with the paper's range."""
    a, b = (ratio.low, ratio.high) if ratio.low is not None and ratio.high is not None else (ratio.value, ratio.value)
    if b < low:
        return "below the paper's range"
    if a > high:
        return "above the paper's range"
    return "within the paper's range" if low <= a and b <= high else "its interval reaches into the paper's range"


def ratios_chapter(tables: Tables) -> Iterator[str]:
    yield "## Ratios that the paper claims\n"
    yield "Times as fast, with 95 % intervals. *Own models* divides the FPS of two rows, each on its own model, as the paper does; seeds are its " \
          "samples, so one seed has no interval. *One model* compares the two modes on the model of the faster row, frame by frame in turns; " \
          "cameras are its samples.\n"
    lines, reasons = [], []
    for claim in PUBLISHED["claims"]:
        for set_name in tables.sets:
            own, one = own_model_ratio(tables, claim, set_name), one_model_ratio(tables, claim, set_name)
            if own or one:
                lines.append([claim["name"], set_name, f"{claim['low']} to {claim['high']}", ratio_text(own), ratio_text(one),
                              verdict(one or own, claim["low"], claim["high"])])
        if any(line[0] == claim["name"] for line in lines):
            reasons.append(f"- {claim['name']}: {claim['cuda' if tables.on_gpu else 'cpu']}")
        else:
            rows = {row.name: row for row in tables.plan.rows}
            why = next((rows[name].why for name in (claim["row"], claim["baseline"]) if name in rows and rows[name].why), "not measured")
            lines.append([claim["name"], NONE, f"{claim['low']} to {claim['high']}", NONE, NONE, why])
    yield from table(["claim", "set", "paper", "own models", "one model", "outcome"], lines)
    if reasons:
        yield "Reasons for differences:\n"
        yield from [*reasons, ""]


def spread(tables: Tables) -> Iterator[str]:
    yield "## Spread of the seeds\n"
    if tables.plan.seeds < 2:
        yield "One seed was trained, so there is no spread: `--seeds 3` measures it.\n"
        return
    lines = []
    for set_name in tables.sets:
        for row in tables.shown(set_name):
            line = [set_name, row.title]
            for quantity in ("psnr", "ssim", "gaussians", "train_seconds"):
                means = tables.seed_means(quantity, row.name, set_name)
                line.append(f"{cell(quantity, min(means))} to {cell(quantity, max(means))}" if len(means) > 1 else NONE)
            lines += [] if row.why else [line]
    yield from table(["set", "row", *(HEADS[q] for q in ("psnr", "ssim", "gaussians", "train_seconds"))], lines)


def counts(tables: Tables) -> Iterator[str]:
    published = PUBLISHED["scenes_3dgs_gaussians"]
    scenes = [scene.name for scene in tables.plan.scenes if scene.set != "Own scenes" and scene.name in published]
    if not scenes:
        return
    yield "## Gaussians of 3DGS\n"
    yield "Published with DashGaussian for 3DGS. The rules of the published trainers meet them within 3 %.\n"
    lines = []
    for scene in scenes:
        values = tables.values("gaussians", "3dgs", scene)
        ours = statistics.fmean(values) if values else None
        lines.append([scene, f"{published[scene]:,}", NONE if ours is None else f"{ours:,.0f}",
                      NONE if ours is None else f"{100 * (ours / published[scene] - 1):+.1f} %"])
    yield from table(["scene", "published", "ours", "difference"], lines)


def pictures_chapter(tables: Tables) -> Iterator[str]:
    yield "## Plots and pictures\n"
    for name, alt in plots(tables):
        yield f"![{alt}](plots/{name}.svg)\n"
    for scene in tables.plan.scenes:
        found = []
        for row in tables.plan.rows:
            file = pathlib.Path(Unit(scene.name, 0, row.model).folder, "crops", f"{row.mode}.png")
            if not found and (tables.folder / file.with_name("photograph.png")).is_file():
                found.append(("photograph", file.with_name("photograph.png")))
            if (tables.folder / file).is_file():
                found.append((row.title, file))
        if len(found) > 1:
            yield f"### A part of {scene.name}, test view {scene.crop[0] if scene.crop else 0}\n"
            yield from table([title for title, _ in found], [[f"![{title}]({file})" for title, file in found]])


def plots(tables: Tables) -> Iterator[tuple[str, str]]:
    """Writes the plots; yields (name, description)."""
    rows = [row for row in tables.plan.rows if not row.why]
    series: dict[str, list[Optional[charts.Bar]]] = {}
    for row in rows:
        bars: list[Optional[charts.Bar]] = []
        for set_name in tables.sets:
            value = tables.whole_mean("fps_paper", row.name, set_name)
            means = tables.seed_means("fps_paper", row.name, set_name)
            bars.append(None if value is None else (value, min(means) if len(means) > 1 else None, max(means) if len(means) > 1 else None))
        series[row.title] = bars
    write_text(tables.folder / "plots/fps.svg", charts.bars("FPS (paper); whiskers: seeds", tables.sets, series))
    yield "fps", "Bars: frames per second of every row"
    quality: dict[str, list[Optional[charts.Bar]]] = {
        row.title: [None if (value := tables.whole_mean("psnr", row.name, name)) is None else (value, None, None) for name in tables.sets]
        for row in rows}
    write_text(tables.folder / "plots/psnr.svg", charts.bars("PSNR on the test views, dB", tables.sets, quality))
    yield "psnr", "Bars: PSNR of every row"
    scene = tables.plan.zoomed()[0]
    if zoomed := read_json(tables.folder / scene / "zoom/zoom.json"):
        last = max(max(row["view"] for row in zoomed["rows"]), 1)
        modes = [*dict.fromkeys(row["mode"] for row in zoomed["rows"])]
        curves = {mode: [(zoomed["closest"] ** (-row["view"] / last), 1000 / row["ms_median"]) for row in zoomed["rows"]
                         if row["mode"] == mode and row["ms_median"] > 0] for mode in modes}
        write_text(tables.folder / "plots/zoom.svg", charts.curves(f"FPS while zooming into {scene}", "zoom", curves))
        yield "zoom", "Curves: frames per second while the camera approaches, one per mode"


def not_reproduced(tables: Tables) -> Iterator[str]:
    yield "## Not reproduced, and why\n"
    plan, lines = tables.plan, []
    for set_name in dict.fromkeys(entry["set"] for entry in plan.missing):
        entries = [entry for entry in plan.missing if entry["set"] == set_name]
        lines.append(f"- {set_name}: {', '.join(entry['scene'] for entry in entries)}: the photographs are not here. Source: "
                     f"{entries[0]['source']}.")
    lines += [f"- {row.title}: {row.why}." for row in plan.rows if row.why]
    lost = [entry for entry in tables.rows if entry["state"] == "missing"]
    for entry in lost:
        lines.append(f"- {entry['scene']}, seed {entry['seed']}, {entry['row']}: not finished.")
    if not tables.has("lpips"):
        lines.append("- LPIPS: no weights were given with `--lpips`; they cannot be shipped with the program.")
    lines.append("- The paper's GPUs, A100 and RTX 4090: FPS belong to a GPU, so ratios are compared instead.")
    lines.append("- Rows of 3DGS, AdR, four boxes and QuadBox that were trained separately: lossless modes train equal models, so their "
                 "differences of quality in the paper are noise of training. `--rows published` trains AdR with its own rules.")
    lines.append("- 305 FPS of AdR in the paper's text: its tables say 302; 305 is Dash + QuadBox.")
    lines.append("- SSIM 0.852 of Compact-3DGS on Tanks and Temples: its own published files say 0.831.")
    yield from [*lines, ""]


def others(tables: Tables) -> Iterator[str]:
    yield "## Other published numbers\n"
    yield from [f"- {entry['set']}: {entry['text']}." for entry in PUBLISHED["others"]]
    yield ""


def provenance(tables: Tables) -> Iterator[str]:
    yield "## Provenance\n"
    yield "One line per training. `rows.csv` has every number with its program, machine and data.\n"
    lines = []
    for unit in tables.plan.units():
        done = read_json(tables.folder / unit.folder / "done.json")
        if done:
            device = f"{done['gpu']}, driver {done['driver']}" if done.get("gpu") else str(done.get("cpu") or NONE)
            lines.append([unit.scene, str(unit.seed), unit.model, str(done["commit"]), device,
                          str(done["data"])[7:19], f"{done['seconds']:,.1f}", str(done["attempts"]), f"{done['bytes'] / 1e6:,.1f}"])
    yield from table(["scene", "seed", "model", "commit", "device", "data, SHA-256", "s", "starts", "MB"], lines)


CHAPTERS = (facts, table_1, table_2, table_3, ratios_chapter, spread, counts, pictures_chapter, others, not_reproduced, provenance)


def write(plan: Plan, folder: pathlib.Path) -> str:
    tables = Tables(plan, folder)
    lines = ["# The paper's tables, measured\n", "Written by `quadsplat paper`.\n"]
    for chapter in CHAPTERS:
        lines += chapter(tables)
    write_text(folder / "report.md", "\n".join(lines))
    return f"wrote {folder / 'report.md'}"


def write_partial(plan: Plan, folder: pathlib.Path) -> str:
    """The report of the results that exist now."""
    return f"{results.write(plan, folder)}; {write(plan, folder)}"
