# SPDX-License-Identifier: MIT
"""Reading and writing of files that appear whole or not at all."""
import csv
import json
import os
import pathlib
from typing import Any, Optional

from .problem import Problem


def write_text(path: pathlib.Path, text: str) -> None:
    """Replaces the file. Raises Problem if the disk is full or the folder cannot be written."""
    hidden = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        hidden.write_text(text, encoding="utf-8")
        hidden.replace(path)
    except OSError as error:
        hidden.unlink(missing_ok=True)
        raise Problem(f"{path}: cannot be written: {error.strerror}") from error


def write_json(path: pathlib.Path, value: Any) -> None:
    write_text(path, json.dumps(value, indent=1, allow_nan=False) + "\n")


def read_json(path: pathlib.Path) -> Optional[Any]:
    """None if the file is missing. Raises Problem if it is no JSON."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError) as error:
        raise Problem(f"{path}: cannot be read: {error}") from error


def write_csv(path: pathlib.Path, columns: list[str], rows: list[dict[str, Any]]) -> None:
    """One line per row; a missing value is empty."""
    lines = [columns] + [["" if row.get(name) is None else str(row[name]) for name in columns] for row in rows]
    write_text(path, "".join(",".join(map(csv_field, line)) + "\n" for line in lines))


def csv_field(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"\n') else text


def read_csv(path: pathlib.Path) -> list[dict[str, str]]:
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def last_line(path: pathlib.Path) -> str:
    """The last line of a log that is not empty; "" without a log."""
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").replace("\r", "\n").split("\n")
    except OSError:
        return ""
    return next((line.strip() for line in reversed(lines) if line.strip()), "")
