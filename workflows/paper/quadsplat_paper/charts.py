# SPDX-License-Identifier: MIT
"""Bar charts and curves as SVG."""
import html
import math
from typing import Optional

COLORS = ("#8c8c8c", "#4878a8", "#d08a34", "#5a9a5a", "#b04a5a", "#7a5aa0", "#3a9a9a", "#a0703a", "#606060", "#c05a9a")
FONT = 'font-family="sans-serif" font-size="12"'


def text(x: float, y: float, words: str, anchor: str = "middle") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" {FONT}>{html.escape(words)}</text>'


def step_of(highest: float) -> float:
    """1, 2 or 5 times a power of ten, for about five lines of a grid."""
    if highest <= 0:
        return 1
    power = 10 ** math.floor(math.log10(highest / 5))
    return next(factor * power for factor in (1, 2, 5, 10) if factor * power >= highest / 5)


def frame(width: int, height: int, title: str, parts: list[str]) -> str:
    return "\n".join([f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}">',
                      f'<rect width="{width}" height="{height}" fill="white"/>',
                      text(width / 2, 18, title), *parts, "</svg>"]) + "\n"


def grid(left: float, right: float, top: float, bottom: float, highest: float) -> list[str]:
    """Horizontal lines with their values; `highest` is at `top`."""
    parts, step = [], step_of(highest)
    for i in range(int(highest / step + 1e-9) + 1):
        y = bottom - (bottom - top) * i * step / highest
        parts += [f'<line x1="{left}" x2="{right}" y1="{y:.1f}" y2="{y:.1f}" stroke="#ddd"/>',
                  text(left - 6, y + 4, f"{i * step:g}", "end")]
    return parts


def legend(x: float, y: float, names: list[str]) -> list[str]:
    parts = []
    for i, name in enumerate(names):
        parts += [f'<rect x="{x}" y="{y + 18 * i}" width="12" height="12" fill="{COLORS[i % len(COLORS)]}"/>',
                  text(x + 18, y + 18 * i + 11, name, "start")]
    return parts


Bar = tuple[float, Optional[float], Optional[float]]  # value, low, high


def bars(title: str, groups: list[str], series: dict[str, list[Optional[Bar]]]) -> str:
    """A group of bars per name of `groups`, a bar per series, with whiskers where low and high are given."""
    highest = 1.05 * max([bar[2] or bar[0] for values in series.values() for bar in values if bar] or [1])
    each = 16
    width = int(70 + len(groups) * (len(series) * each + 24) + 190)
    top, bottom, left, right = 34.0, 270.0, 60.0, width - 180.0
    parts = grid(left, right, top, bottom, highest)
    for g, group in enumerate(groups):
        start = left + 12 + g * (len(series) * each + 24)
        for s, values in enumerate(series.values()):
            if not (bar := values[g]):
                continue
            value, low, high = bar
            x, y = start + s * each, bottom - (bottom - top) * value / highest
            parts.append(f'<rect x="{x:.1f}" y="{y:.1f}" width="{each - 3}" height="{bottom - y:.1f}" fill="{COLORS[s % len(COLORS)]}"/>')
            if low is not None and high is not None:
                ends = [bottom - (bottom - top) * end / highest for end in (low, high)]
                middle = x + (each - 3) / 2
                parts.append(f'<line x1="{middle:.1f}" x2="{middle:.1f}" y1="{ends[0]:.1f}" y2="{ends[1]:.1f}" stroke="black"/>')
        parts.append(text(start + len(series) * each / 2, bottom + 16, group))
    return frame(width, 300, title, parts + legend(right + 12, top, [*series]))


def curves(title: str, below: str, series: dict[str, list[tuple[float, float]]]) -> str:
    """Curves over a logarithmic axis; `below` names it."""
    points = [point for values in series.values() for point in values]
    highest = 1.05 * max([y for _, y in points] or [1])
    lowest_x, highest_x = (min(x for x, _ in points), max(x for x, _ in points)) if points else (1, 2)
    span = math.log(highest_x / lowest_x) or 1
    top, bottom, left, right = 34.0, 270.0, 60.0, 460.0
    parts = grid(left, right, top, bottom, highest)
    for s, values in enumerate(series.values()):
        line = " ".join(f"{left + (right - left) * math.log(x / lowest_x) / span:.1f},{bottom - (bottom - top) * y / highest:.1f}"
                        for x, y in values)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{COLORS[s % len(COLORS)]}" stroke-width="2"/>')
    parts += [text(left, bottom + 16, f"{lowest_x:.3g}"), text(right, bottom + 16, f"{highest_x:.3g}"),
              text((left + right) / 2, bottom + 16, below)]
    return frame(640, 300, title, parts + legend(right + 12, top, [*series]))
