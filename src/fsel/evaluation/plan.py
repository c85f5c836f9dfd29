"""Cameras seen from above."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fsel.core.capture import Capture
from fsel.core.geometry import plane_basis, upwards

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plan_positions(capture: Capture) -> np.ndarray:
    """(N, 2) camera centres on the horizontal plane, world units, centred on their middle."""
    flat = capture.centers @ np.stack(plane_basis(upwards(capture.world_to_camera)), axis=1)
    return flat - (flat.min(axis=0) + flat.max(axis=0)) / 2


def draw_cameras(axis: Axes, places: np.ndarray, targets: np.ndarray, size: float = 4.0) -> None:
    """All cameras as grey dots and the targets as open diamonds; equal scales, no ticks.

    Args:
        axis: to draw into.
        places: (N, 2) see `plan_positions`.
        targets: frames.
        size: of a dot's diameter, points.
    """
    axis.plot(*places.T, "o", color="0.8", markersize=size / 2, markeredgewidth=0, zorder=1)
    axis.plot(
        *places[targets].T, "D", color="none", markeredgecolor="black", markersize=size, zorder=3
    )
    axis.set_aspect("equal", adjustable="datalim")
    axis.margins(0.08)
    axis.set_xticks([])
    axis.set_yticks([])
