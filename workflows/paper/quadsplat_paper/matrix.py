# SPDX-License-Identifier: MIT
"""The rows of the paper's tables, and the models that must be trained for them.

Lossless modes give equal models, so their rows share one. To add a row: a line of ROWS, and its model in MODELS.
"""
import dataclasses
import json
import pathlib
from typing import Any, Optional

from .problem import EXIT_USAGE, Problem
from .program import Program

PAPER_MODES = ("3dgs", "adr", "dualbox", "quadbox-naive", "quadbox")
SIMPLE_MODES = ("3dgs", "quadbox")  # those of the rows with another strategy


@dataclasses.dataclass
class Model:
    """A training that every scene and seed needs."""
    name: str
    options: list[str]                    # options of `train`
    wishes: list[list[str]] = dataclasses.field(default_factory=list)  # options that an older program may lack
    modes: list[str] = dataclasses.field(default_factory=lambda: [*PAPER_MODES])  # measured by `bench`
    cost: float = 1                       # seconds in units of a `quadbox` training
    sets: Optional[list[str]] = None      # None: all
    command: Optional[list[str]] = None   # a training program of its own instead of `train`
    plugin: Optional[str] = None          # a renderer that `bench` measures on this model

    def __post_init__(self) -> None:
        if self.command is None and "--strategy" not in self.options:
            self.options = ["--strategy", "adc", *self.options]  # the paper's, not the default of `train`

    def strategy(self) -> str:
        return self.options[self.options.index("--strategy") + 1]


@dataclasses.dataclass
class Row:
    """A row of the tables: a model drawn in a mode, or by a plugin."""
    name: str
    title: str
    model: str
    mode: str
    why: str = ""  # the reason why it cannot be measured; "": it can
    notes: list[str] = dataclasses.field(default_factory=list)


MAPS = ["Mip-NeRF 360"]  # the set of the paper's ablation
OWN_TOO = [*MAPS, "Own scenes"]


def base_models() -> list[Model]:
    counted = [["--count-views", "mode"]]
    dash = ["--strategy", "dash"]
    variant = [["--dash-variant", "2025-06"]]
    field = [["--color-field"]]
    return [
        Model("3dgs", ["--cull", "3dgs"], counted, cost=1.13),
        Model("quadbox", ["--cull", "quadbox"]),
        Model("dualbox", ["--cull", "dualbox"], sets=OWN_TOO, cost=1),
        Model("dash", [*dash, "--cull", "3dgs"], variant, [*SIMPLE_MODES], 0.54),
        Model("dash-quadbox", [*dash, "--cull", "quadbox"], variant, [*SIMPLE_MODES], 0.54),
        Model("mask", ["--strategy", "mask", "--cull", "3dgs"], field, [*SIMPLE_MODES], 1.7),
        Model("mask-quadbox", ["--strategy", "mask", "--cull", "quadbox"], field, [*SIMPLE_MODES], 1.7),
    ]


def published_models() -> list[Model]:
    """The same, but every mode counts its own views, with the rules of the published trainers."""
    models = {model.name: model for model in base_models()}
    models["quadbox"].wishes = [["--count-views", "mode"], ["--step-before-densify"]]
    adr = Model("adr", ["--cull", "adr"], [["--count-views", "mode"], ["--opacity-rate", "0.05"]])
    return [models.pop("3dgs"), adr, *models.values()]


def paper_rows(published: bool) -> list[Row]:
    return [
        Row("3dgs", "3DGS", "3dgs", "3dgs"),
        Row("adr", "AdR-AABB", "adr" if published else "quadbox", "adr"),
        Row("dualbox", "DualBox", "dualbox", "dualbox"),
        Row("quadbox-naive", "QuadBox, four boxes", "quadbox", "quadbox-naive"),
        Row("quadbox", "QuadBox", "quadbox", "quadbox"),
        Row("dash", "Dash", "dash", "3dgs"),
        Row("dash+quadbox", "Dash + QuadBox", "dash-quadbox", "quadbox"),
        Row("mask", "Compact-3DGS", "mask", "3dgs"),
        Row("mask+quadbox", "Compact-3DGS + QuadBox", "mask-quadbox", "quadbox"),
    ]


# ---- methods of users ---------------------------------------------------------------------------

METHOD_KEYS = {"name", "title", "options", "command", "plugin", "model", "mode"}


def own_methods(file: pathlib.Path) -> tuple[list[Model], list[Row]]:
    """Reads --methods FILE; docs/workflow.md describes it. Raises Problem."""
    try:
        methods = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise Problem(f"--methods: {file}: cannot be read: {error}") from error
    if not isinstance(methods, list):
        raise Problem(f"--methods: {file}: is no list of methods")
    models, rows = [], []
    for number, method in enumerate(methods):
        model, row = own_method(method, f"--methods: {file}: method {number + 1}", file.parent)
        models += [model] if model else []
        rows.append(row)
    return models, rows


def own_method(method: Any, who: str, folder: pathlib.Path) -> tuple[Optional[Model], Row]:
    if not isinstance(method, dict) or not isinstance(method.get("name"), str) or not is_name(method["name"]):
        raise Problem(f"{who}: needs a \"name\" of letters, digits, '_', '.', '+' and '-'")
    name = method["name"]
    if unknown := sorted(set(method) - METHOD_KEYS):
        raise Problem(f"{who}: '{unknown[0]}' is none of {', '.join(sorted(METHOD_KEYS))}")
    given = [key for key in ("options", "command", "plugin") if key in method]
    if len(given) != 1:
        raise Problem(f"{who}: needs exactly one of \"options\", \"command\" and \"plugin\"")
    row = Row(name, str(method.get("title", name)), name, str(method.get("mode", "quadbox")))
    if given == ["plugin"]:
        library = folder / str(method["plugin"])
        row.mode = str(method.get("mode", name))
        row.model = str(method.get("model", "quadbox"))
        model = Model(name, [], plugin=str(library.resolve()))
        row.notes.append(f"plugin on the model of {row.model}")
        return model, row
    words = method[given[0]]
    if not isinstance(words, list) or not words or not all(isinstance(word, str) for word in words):
        raise Problem(f"{who}: \"{given[0]}\" is no list of words")
    modes = [*dict.fromkeys((*SIMPLE_MODES, row.mode))]
    return Model(name, words if given == ["options"] else [], modes=modes, command=words if given == ["command"] else None), row


def is_name(text: str) -> bool:
    return text != "" and text[0] not in ".-" and all(c.isascii() and (c.isalnum() or c in "_.+-") for c in text)


# ---- the choice ---------------------------------------------------------------------------------


def choose(program: Program, names: list[str], methods: Optional[pathlib.Path]) -> tuple[list[Model], list[Row]]:
    """The rows that --rows names, and the models that they need.

    A row that the program cannot train keeps its place, and says why. Raises Problem.
    """
    published = "published" in names
    models = published_models() if published else base_models()
    rows = paper_rows(published)
    own_models, own_rows = own_methods(methods) if methods else ([], [])
    known = [row.name for row in rows]
    for row in own_rows:
        if row.name in known:
            raise Problem(f"--methods: {methods}: there are two rows named {row.name}")
        known.append(row.name)
    rows += own_rows
    if wrong := [name for name in names if name not in (*known, "all", "published")]:
        raise Problem(f"--rows: '{wrong[0]}' is none of {', '.join(known)}, all, published", EXIT_USAGE)
    if names and not {"all", "published"} & set(names):
        rows = [row for row in rows if row.name in names]
    by_name = {model.name: model for model in models + own_models}
    strategies = program.strategies()
    for row in rows:
        model = by_name.get(row.model)
        if model is None or model.plugin:
            raise Problem(f"--methods: {methods}: row {row.name}: there is no model '{row.model}'")
        if model.command is None and model.strategy() not in strategies:
            row.why = f"not available in this program: train has no strategy '{model.strategy()}'"
        else:
            grant_wishes(program, model, row)
    for plugin in (model for model in own_models if model.plugin):
        if target := next((row.model for row in rows if row.name == plugin.name), None):
            by_name[target].plugin = ",".join(filter(None, (by_name[target].plugin, plugin.plugin)))
    needed = {row.model for row in rows if not row.why}
    return [model for model in by_name.values() if model.name in needed], rows


def grant_wishes(program: Program, model: Model, row: Row) -> None:
    """Adds the options that the program has; the row notes the others."""
    for wish in model.wishes:
        if model.command is not None:
            continue
        if program.offers("train", wish[0]):
            if wish[0] not in model.options:
                model.options += wish
        else:
            row.notes.append(f"trained without '{' '.join(wish)}', which this program does not have")
