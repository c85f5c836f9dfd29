"""Rendered views of several selections beside the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fsel.report.figures import footnote, save
from fsel.report.plan import draw_cameras

COLUMN = 1.35  # inches


@dataclass(frozen=True)
class Shown:
    """One selection's column.

    Attributes:
        title: heading, line breaks allowed.
        rendered: (T, h, w, 3) float32 in [0, 1].
        psnr: (T,) of each view, dB.
        frames: selected frames, drawn from above.
    """

    title: str
    rendered: np.ndarray
    psnr: np.ndarray
    frames: np.ndarray


def draw(
    truth: np.ndarray,
    columns: Sequence[Shown],
    places: np.ndarray,
    targets: np.ndarray,
    outputs: Sequence[str | Path],
    note: str,
) -> None:
    """Rows: targets, then the selected cameras in plan view. Columns: the truth, the selections.

    Args:
        truth: (T, h, w, 3) uint8.
        columns: in order.
        places: (N, 2) cameras from above.
        targets: all held-out frames, drawn from above.
        outputs: paths; their endings choose the format.
        note: what made the numbers.
    """
    rows, (height, width) = len(truth), truth.shape[1:3]
    row = COLUMN * height / width + 0.18
    size = ((len(columns) + 1) * COLUMN, rows * row + COLUMN + 0.75)
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(
        rows + 1, len(columns) + 1, squeeze=False, height_ratios=[row] * rows + [COLUMN]
    )
    for y in range(rows):
        _image(axes[y, 0], truth[y], "")
        for x, column in enumerate(columns, 1):
            _image(axes[y, x], np.clip(column.rendered[y], 0, 1), f"{column.psnr[y]:.2f} dB")
    axes[0, 0].set_title("held-out view", fontsize=7)
    axes[rows, 0].axis("off")
    for x, column in enumerate(columns, 1):
        axes[0, x].set_title(column.title, fontsize=7)
        draw_cameras(axes[rows, x], places, targets, 3.0)
        axes[rows, x].plot(*places[column.frames].T, "o", color="tab:red", markersize=3, zorder=4)
    footnote(figure, note)
    save(figure, outputs)


def _image(axis: Axes, image: np.ndarray, label: str) -> None:
    axis.imshow(image, interpolation="nearest")
    axis.set_xlabel(label, fontsize=6, labelpad=1)
    axis.set_xticks([])
    axis.set_yticks([])
