"""Drawings of a selection as SVG: the cameras from above, service against K, sharpness."""

from __future__ import annotations

from html import escape

import numpy as np

from fsel.data.geometry import upwards
from fsel.data.subsets import evenly
from fsel.export.record import Outcome
from fsel.request.paths import plane_basis

SIDE = 640  # of the top view, in units of its view box
MARGIN = 30
TICK = 0.035  # length of a viewing direction, as a share of the side
CHART = (640, 260)
SHOWN = 3000  # frames, targets or rows of a report at most: 50,000 would take 12 MB
TIMELINE = 10  # margin of the timeline of sharpness
LEFT, BOTTOM = 60, 46  # room for the chart's labels, which are larger on narrow screens


def shown(count: int) -> list[int]:
    """Numbers of the frames, targets or rows that a report shows: all, or evenly spread ones."""
    return evenly(count, SHOWN).tolist()


def top_view(outcome: Outcome) -> str:
    """Cameras, targets and picks in order, from above; a tick shows where each looks."""
    capture, targets, selection = outcome.capture, outcome.targets, outcome.selection
    side, ahead = plane_basis(upwards(capture.world_to_camera))
    basis = np.stack([side, -ahead], axis=1)  # SVG counts downwards
    near = targets.views.centers[~targets.far]
    centers = np.concatenate([capture.centers, near]) @ basis
    low, high = centers.min(axis=0), centers.max(axis=0)
    extent = float((high - low).max()) or 1.0  # all cameras in one place: in the middle
    inner = SIDE - 2 * MARGIN
    offset = MARGIN + inner * (1 - (high - low) / extent) / 2
    places = (centers - low) / extent * inner + offset
    axes = np.concatenate([capture.axes, targets.views.axes[~targets.far]]) @ basis
    ends = places + TICK * SIDE * axes
    count = len(capture)
    height = (high - low)[1] / extent * inner + 2 * MARGIN
    shift = (SIDE - height) / 2
    marks = [
        f'<svg viewBox="0 {shift:.1f} {SIDE} {height:.1f}" class="top" role="img" '
        'aria-label="cameras from above">'
    ]
    for i in shown(count):
        marks.append(_camera(places[i], ends[i], "frame", capture.names[i]))
    for i in shown(len(places) - count):
        marks.append(_target(places[count + i], ends[count + i], f"target {i}"))
    for order, i in reversed(list(enumerate(selection.indices, 1))):  # the first lies on top
        x, y = places[i]
        marks.append(_camera(places[i], ends[i], "pick", f"{order}: {capture.names[i]}", 8.5))
        marks.append(f'<text class="order" x="{x:.1f}" y="{y + 3.2:.1f}">{order}</text>')
    return "\n".join([*marks, "</svg>"])


def _camera(place: np.ndarray, end: np.ndarray, kind: str, title: str, radius: float = 2.5) -> str:
    (x, y), (u, v) = place, end
    return (
        f'<g class="{kind}"><title>{escape(title)}</title>'
        f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{u:.1f}" y2="{v:.1f}"/>'
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius}"/></g>'
    )


def _target(place: np.ndarray, end: np.ndarray, title: str) -> str:
    (x, y), (u, v) = place, end
    return (
        f'<g class="target"><title>{escape(title)}</title>'
        f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{u:.1f}" y2="{v:.1f}"/>'
        f'<rect x="{x - 4:.1f}" y="{y - 4:.1f}" width="8" height="8" '
        f'transform="rotate(45 {x:.1f} {y:.1f})"/></g>'
    )


def service_chart(curve: np.ndarray) -> str:
    """Service after each pick."""
    width, height = CHART
    right, top = width - 12, 12

    def at(k: float, share: float) -> tuple[float, float]:
        x = LEFT + (right - LEFT) * k / len(curve)
        return x, height - BOTTOM - (height - BOTTOM - top) * share

    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in (at(k, c) for k, c in enumerate([0, *curve])))
    marks = [
        f'<svg viewBox="0 0 {width} {height}" class="chart" role="img" '
        'aria-label="service against K">'
    ]
    for share in (0, 0.25, 0.5, 0.75, 1):
        (x, y), (far, _) = at(0, share), at(len(curve), share)
        marks.append(f'<line class="grid" x1="{x}" y1="{y:.1f}" x2="{far}" y2="{y:.1f}"/>')
        marks.append(f'<text class="left" x="{x - 6}" y="{y + 4:.1f}">{share:.0%}</text>')
    step = max(1, round(len(curve) / 8))
    for k in range(0, len(curve) + 1, step):
        x, y = at(k, 0)
        marks.append(f'<text class="below" x="{x:.1f}" y="{y + 19:.1f}">{k}</text>')
    marks.append(f'<polyline points="{path}"/>')
    middle = (LEFT + right) / 2
    marks.append(f'<text class="below" x="{middle}" y="{height - 3}">frames picked</text>')
    return "\n".join([*marks, "</svg>"])


def sharpness_chart(sharpness: np.ndarray, picks: np.ndarray) -> str:
    """A bar for every frame, the picks' marked."""
    width, height = CHART[0] * 2, 140
    tallest = float(sharpness.max()) or 1.0
    step = (width - 2 * TIMELINE) / len(sharpness)
    chosen = set(picks.tolist())
    marks = [
        f'<svg viewBox="0 0 {width} {height}" class="timeline" preserveAspectRatio="none" '
        'role="img" aria-label="sharpness of every frame">'
    ]
    for frame in shown(len(sharpness)):
        tall = (height - 2 * TIMELINE) * sharpness[frame] / tallest
        kind = "pick" if frame in chosen else "other"
        x, y = TIMELINE + frame * step, height - TIMELINE - tall
        marks.append(
            f'<rect class="{kind}" x="{x:.1f}" y="{y:.1f}" width="{max(0.8 * step, 0.5):.1f}" '
            f'height="{tall:.1f}"/>'
        )
    return "\n".join([*marks, "</svg>"])
