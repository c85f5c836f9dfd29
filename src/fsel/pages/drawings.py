"""Charts as SVG: lines with intervals, and a timeline of all frames."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape

import numpy as np

CHART = (640, 260)
LEFT, BOTTOM = 60, 46  # room for the chart's labels, which are larger on narrow screens
SPREAD = 7  # pixels between the intervals of two lines
TICKS = 6  # on the vertical axis at most
WIDE, ROW, NAME = 1280, 46, 26  # pixels of the timeline, of one measure, and of its name above it

Place = tuple[float, float]


@dataclass(frozen=True)
class Line:
    """A line of a chart: (n,) points, and the ends of their intervals, NaN where there is none."""

    x: np.ndarray
    y: np.ndarray
    low: np.ndarray = field(default_factory=lambda: np.empty(0))
    high: np.ndarray = field(default_factory=lambda: np.empty(0))


def line_chart(lines: Mapping[str, Line], across: str, unit: str, label: str) -> str:
    """Draw lines with their intervals, classes `line0`, `line1`, ..., over an axis; `unit` formats
    the vertical axis, and `label` is for those who do not see the chart."""
    width, height = CHART
    right, top = width - 12, 12
    low, high = _reach([np.concatenate([line.y, line.low, line.high]) for line in lines.values()])
    first, last = _reach([line.x for line in lines.values()])
    room = SPREAD * len(lines) / width * (last - first)  # intervals at the ends lie side by side
    first, last = first - room, last + room

    def at(x: float, y: float) -> Place:
        side = LEFT + (right - LEFT) * (x - first) / (last - first)
        return side, height - BOTTOM - (height - BOTTOM - top) * (y - low) / (high - low)

    marks = [f'<svg viewBox="0 0 {width} {height}" class="chart" role="img" aria-label="{label}">']
    for value in _ticks(low, high):
        x, y = at(first, value)
        marks.append(f'<line class="grid" x1="{x}" y1="{y:.1f}" x2="{right}" y2="{y:.1f}"/>')
        marks.append(f'<text class="left" x="{x - 6}" y="{y + 4:.1f}">{value:{unit}}</text>')
    known = np.unique(np.concatenate([line.x for line in lines.values()]))
    for value in known[:: max(1, round(len(known) / 8))]:
        x, y = at(value, low)
        marks.append(f'<text class="below" x="{x:.1f}" y="{y + 19:.1f}">{value:g}</text>')
    for number, (name, line) in enumerate(lines.items()):
        shift = SPREAD * (number - (len(lines) - 1) / 2)
        marks.append(f'<g class="line{number}"><title>{escape(name)}</title>')
        marks.append(f"{_drawn(line, at, shift)}</g>")
    middle = (LEFT + right) / 2
    marks.append(f'<text class="below" x="{middle}" y="{height - 3}">{escape(across)}</text></svg>')
    return "\n".join(marks)


def _drawn(line: Line, at: Callable[[float, float], Place], shift: float) -> str:
    """Draw a line, and its intervals so many pixels beside it."""
    ends = zip(line.x, line.low, line.high, strict=True) if len(line.low) else ()
    places = [(at(x, low), at(x, high)) for x, low, high in ends if np.isfinite(low)]
    bars = [
        f'<path d="M{x + shift:.1f} {under:.1f}V{over:.1f}"/>' for (x, under), (_, over) in places
    ]
    points = [at(x, y) for x, y in zip(line.x, line.y, strict=True)]
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return "".join([*bars, f'<polyline points="{path}"/>'])


def legend(names: Iterable[str]) -> str:
    """Return the names of a chart's lines beside their colours."""
    spans = [
        f'<span><svg class="swatch" viewBox="0 0 34 10"><line class="line{at}" x1="0" y1="5" '
        f'x2="34" y2="5"/></svg>{escape(name)}</span>'
        for at, name in enumerate(names)
    ]
    return f'<p class="legend">{" ".join(spans)}</p>'


def _reach(values: Sequence[np.ndarray]) -> tuple[float, float]:
    """Return the least and the greatest of finite numbers, never the same."""
    every = np.concatenate(values)
    every = every[np.isfinite(every)]
    low, high = float(every.min()), float(every.max())
    return (low, high) if high > low else (low - 0.5, low + 0.5)


def _ticks(low: float, high: float) -> np.ndarray:
    """Round numbers between two, a power of ten or its double, its quarter or its half apart."""
    power = 10.0 ** np.floor(np.log10((high - low) / TICKS))
    step = next(power * by for by in (1, 2, 2.5, 5, 10) if power * by * TICKS >= high - low)
    first, last = np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9)
    return step * np.arange(first, last + 1) + 0.0  # not -0


def timeline(rows: Mapping[str, np.ndarray], marks: Mapping[str, Sequence[int]]) -> str:
    """Draw a row for each measure, (n,) of all frames or NaN, scaled to its greatest value; `marks`
    maps a class, as `pick`, to the frames it marks."""
    count = len(next(iter(rows.values())))
    step = WIDE / count
    height = len(rows) * (NAME + ROW)
    parts = [
        f'<svg id="timeline" viewBox="0 0 {WIDE} {height}" class="timeline" role="img" '
        f'preserveAspectRatio="none" aria-label="{", ".join(rows)} of frames">'
    ]
    for kind, frames in marks.items():
        bars = "".join(f"M{(frame + 0.5) * step:.1f} 0V{height}" for frame in frames)
        parts.append(f'<path class="{kind}" d="{bars}"/>')
    for number, values in enumerate(rows.values()):
        bottom = (number + 1) * (NAME + ROW) - 4
        tallest = float(np.nanmax(values, initial=0)) or 1.0
        points = [
            f"{(frame + 0.5) * step:.1f},{bottom - ROW * values[frame] / tallest:.1f}"
            for frame in np.flatnonzero(np.isfinite(values))
        ]
        parts.append(f'<line class="grid" x1="0" y1="{bottom}" x2="{WIDE}" y2="{bottom}"/>')
        parts.append(f'<polyline points="{" ".join(points)}"/>')
    return "\n".join([*parts, f'<path id="now" d="M-9 0V{height}"/></svg>'])
