"""Common parts of all figures: sizes as they are printed, styles that survive grey printing."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsel.core.capture import Capture
from fsel.core.geometry import plane_basis, upwards

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TEXT = 6.875  # inches, the width of the text of a two-column paper
LETTERS = 21  # of the footnote's size, an inch
SHARPNESS = 200  # pixels an inch, of a .png and of images within a .pdf
COLORS = (
    *("#d55e00", "#0072b2", "#009e73", "#cc79a7"),
    *("#000000", "#e69f00", "#56b4e9", "#8c510a"),
)
"""Colours that colour-blind readers distinguish (Okabe and Ito, 2008), and a brown."""


def new_figure(size: tuple[float, float]) -> Figure:
    """Create an empty figure of a width and height in inches, without a window."""
    from matplotlib.figure import Figure  # here: jobs that draw nothing do without

    return Figure(figsize=size, layout="constrained")


def name_axes(axis: Axes, across: str, up: str) -> None:
    """Write what the horizontal and the vertical axis measure."""
    axis.set_xlabel(across, fontsize=8)
    axis.set_ylabel(up, fontsize=8)
    axis.tick_params(labelsize=7)


def footnote(figure: Figure, text: str) -> None:
    """Write a small line under a figure, wrapped to its width: what made the numbers."""
    width = int(LETTERS * figure.get_figwidth())
    figure.supxlabel("\n".join(textwrap.wrap(text, width)), fontsize=6)


def save(figure: Figure, outputs: Sequence[str | Path], sharpness: int = SHARPNESS) -> None:
    """Write a figure to paths whose endings choose the format; equal figures give equal bytes."""
    for output in outputs:
        undated = {"CreationDate": None} if Path(output).suffix == ".pdf" else {"Software": None}
        figure.savefig(output, dpi=sharpness, metadata=undated)


def plan_positions(capture: Capture) -> np.ndarray:
    """Return (N, 2) camera centres on the horizontal plane, world units, about their middle."""
    flat = capture.centers @ np.stack(plane_basis(upwards(capture.world_to_camera)), axis=1)
    return flat - (flat.min(axis=0) + flat.max(axis=0)) / 2


def draw_cameras(axis: Axes, places: np.ndarray, targets: np.ndarray, size: float = 4.0) -> None:
    """Draw cameras at (N, 2) `plan_positions` as grey dots and the targets as open diamonds of a
    size in points; equal scales, no ticks."""
    axis.plot(*places.T, "o", color="0.8", markersize=size / 2, markeredgewidth=0, zorder=1)
    axis.plot(
        *places[targets].T, "D", color="none", markeredgecolor="black", markersize=size, zorder=3
    )
    axis.set_aspect("equal", adjustable="datalim")
    axis.margins(0.08)
    axis.set_xticks([])
    axis.set_yticks([])
