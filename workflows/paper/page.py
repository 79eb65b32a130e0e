#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Puts the tables of a run into a page, between the lines <!-- tables --> and <!-- end of tables -->.

  page.py OUT PAGE    for example: workflows/paper/page.py ~/tables docs/paper.md
Chapters go one level deeper. Plots are copied to a folder beside PAGE, named like it without its ending; other pictures
stay in OUT. Exit code 1: OUT has no report, or PAGE no such lines.
"""
import pathlib
import re
import shutil
import sys

BEGIN, END = "<!-- tables -->", "<!-- end of tables -->"


PLOT = re.compile(r"\]\(plots/([^)]+)\)")


def body(report: str, plots: str) -> str:
    """The report without its title and rendered pictures, one level deeper, with plots in the folder `plots`."""
    text = report.split("\n", 1)[1].replace("\n#", "\n##")
    text = re.sub(r"\n#### A part of .*?(?=\n### |\Z)", "", text, flags=re.S)
    return PLOT.sub(rf"]({plots}/\1)", text.replace("\n### Plots and pictures\n", "\n### Plots\n")).strip()


def copy_plots(report: str, folder: pathlib.Path, plots: pathlib.Path) -> None:
    for name in PLOT.findall(report):
        plots.mkdir(exist_ok=True)
        shutil.copyfile(folder / "plots" / name, plots / name)


def main(words: list[str]) -> int:
    if len(words) != 2:
        print(__doc__, file=sys.stderr)
        return 1
    report, page = pathlib.Path(words[0], "report.md"), pathlib.Path(words[1])
    if not report.is_file():
        print(f"page.py: {report}: is missing: run 'quadsplat paper' first", file=sys.stderr)
        return 1
    text = page.read_text(encoding="utf-8")
    if BEGIN not in text or END not in text:
        print(f"page.py: {page}: lacks the lines {BEGIN} and {END}", file=sys.stderr)
        return 1
    before, after = text.split(BEGIN, 1)[0], text.split(END, 1)[1]
    tables = report.read_text(encoding="utf-8")
    copy_plots(tables, report.parent, page.with_suffix(""))
    page.write_text(f"{before}{BEGIN}\n\n{body(tables, page.stem)}\n\n{END}{after}", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
