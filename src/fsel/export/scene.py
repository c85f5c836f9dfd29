"""Scene of the report's turning view: cameras, picks, targets and points."""

from __future__ import annotations

import json
from importlib.resources import files

import numpy as np

from fsel.data.geometry import upwards
from fsel.data.points import SparsePoints
from fsel.data.subsets import evenly
from fsel.export.record import Outcome
from fsel.request.paths import plane_basis

SCRIPT = files("fsel.export") / "scene.js"
MOST_POINTS = 4000
MOST_FRAMES = 2000  # cameras that are drawn beside the picks
TICK = 0.08  # length of a viewing direction, as a share of the view
CORE = 95  # per cent of the points that the view is scaled to, where they lie close enough
WIDEST = 1.5  # times the cameras' own reach: farther points would make one dot of the cameras


def turning_view(outcome: Outcome, points: SparsePoints | None) -> str:
    """A canvas that turns and zooms, its data and its script; hidden where no script runs.

    Args:
        outcome: the selection.
        points: sparse points of the scene, or None.
    """
    content = json.dumps(scene_data(outcome, points), separators=(",", ":"))
    return (
        '<canvas id="scene" class="scene" tabindex="0" role="img" hidden aria-label="cameras and '
        'points; turn with the arrow keys, zoom with plus and minus"></canvas>'
        f'<script type="application/json" id="scene-data">{content}</script>'
        f"<script>{SCRIPT.read_text(encoding='utf-8')}</script>"
    )


def scene_data(outcome: Outcome, points: SparsePoints | None) -> dict:
    """Places around the origin, with z upwards, of extent 1: `frames`, `targets`, `picks` (place
    and tip of the viewing direction each) and `points` (place and colour)."""
    capture, near = outcome.capture, ~outcome.targets.far
    up = upwards(capture.world_to_camera)
    side, ahead = plane_basis(up)
    basis = np.stack([side, ahead, up], axis=1)
    centers = capture.centers @ basis
    views = outcome.targets.views
    targets = views.centers[near] @ basis
    cloud = np.empty((0, 3)) if points is None else points.xyz @ basis
    extent, middle = _extent(np.concatenate([centers, targets]), cloud)

    def drawn(places: np.ndarray, axes: np.ndarray) -> list:
        put = (places - middle) / extent
        return np.stack([put, put + TICK * axes], axis=1).round(4).tolist()

    axes = capture.axes @ basis
    others = np.setdiff1d(np.arange(len(capture)), outcome.selection.indices)
    others = others[evenly(len(others), MOST_FRAMES)]
    some = evenly(len(cloud), MOST_POINTS)
    colours = np.empty((0, 3)) if points is None else points.rgb[some]
    return {
        "frames": drawn(centers[others], axes[others]),
        "targets": drawn(targets, views.axes[near] @ basis),
        "picks": drawn(centers[outcome.selection.indices], axes[outcome.selection.indices]),
        "points": [
            [*place, *colour]
            for place, colour in zip(
                ((cloud[some] - middle) / extent).round(4).tolist(), colours.tolist(), strict=True
            )
        ],
    }


def _extent(cameras: np.ndarray, cloud: np.ndarray) -> tuple[float, np.ndarray]:
    """Extent and middle of the view: all cameras, and near points around them."""
    middle = (cameras.min(axis=0) + cameras.max(axis=0)) / 2
    reach = float(np.linalg.norm(cameras - middle, axis=1).max())
    far = np.linalg.norm(cloud - middle, axis=1)
    core = float(np.percentile(far, CORE)) if len(far) else 0.0
    around = min(core, WIDEST * reach) if reach else core
    return max(reach, around) or 1.0, middle
