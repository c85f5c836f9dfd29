"""Rendered views of several selections beside the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsel.evaluation.figures import COLORS, TEXT, footnote, new_figure, save
from fsel.evaluation.plan import draw_cameras

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.image import AxesImage

PIXELS = 384  # of an image's longer side, in what is saved
INSET = 0.34  # of an image's sides
WORST = 0.2  # mean absolute error that the brightest colour of an inset stands for
ERRORS = "inferno"


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

    Each rendered image has its error in the corner where those of its row are the least wrong.

    Args:
        truth: (T, h, w, 3) uint8.
        columns: in order.
        places: (N, 2) cameras from above.
        targets: all held-out frames, drawn from above.
        outputs: paths; their endings choose the format.
        note: what made the numbers.
    """
    rows, (height, width) = len(truth), truth.shape[1:3]
    wide = TEXT / (len(columns) + 1)
    row = wide * height / width + 0.16
    size = (TEXT, rows * row + wide + 0.75)
    figure = new_figure(size)
    axes = figure.subplots(
        rows + 1, len(columns) + 1, squeeze=False, height_ratios=[row] * rows + [wide]
    )
    for y in range(rows):
        _image(axes[y, 0], truth[y] / 255, "")
        # mean absolute differences of the three colours, in 0..1
        errors = [np.abs(one.rendered[y] - truth[y] / 255.0).mean(axis=-1) for one in columns]
        place = _calmest(np.mean(errors, axis=0))
        for x, (column, error) in enumerate(zip(columns, errors, strict=True), 1):
            _image(axes[y, x], np.clip(column.rendered[y], 0, 1), f"{column.psnr[y]:.2f} dB")
            shown = _errors(axes[y, x].inset_axes((*place, INSET, INSET)), error)
    axes[0, 0].set_title("held-out view", fontsize=7)
    axes[rows, 0].axis("off")
    scale = axes[rows, 0].inset_axes((0.1, 0.6, 0.8, 0.06))
    figure.colorbar(shown, cax=scale, orientation="horizontal", ticks=[0, WORST])
    scale.set_title("error (inset)", fontsize=7)
    scale.tick_params(labelsize=7)
    for x, column in enumerate(columns, 1):
        axes[0, x].set_title(column.title, fontsize=7)
        draw_cameras(axes[rows, x], places, targets, 3.0)
        axes[rows, x].plot(*places[column.frames].T, "o", color=COLORS[0], markersize=3, zorder=2)
    footnote(figure, note)
    save(figure, outputs, round(PIXELS / (wide * max(1, height / width))))


def _image(axis: Axes, image: np.ndarray, label: str) -> None:
    axis.imshow(image, interpolation="antialiased")
    axis.set_xlabel(label, fontsize=7, labelpad=2)
    axis.set_xticks([])
    axis.set_yticks([])


def _calmest(error: np.ndarray) -> tuple[float, float]:
    """Lower left end, as shares of the sides, of the inset in the corner with the least error."""
    high, wide = (round(INSET * side) for side in error.shape)
    rows = {0.0: slice(-high, None), 1 - INSET: slice(high)}  # rows of an image count from above
    columns = {0.0: slice(wide), 1 - INSET: slice(-wide, None)}
    return min(product(columns, rows), key=lambda at: error[rows[at[1]], columns[at[0]]].mean())


def _errors(axis: Axes, error: np.ndarray) -> AxesImage:
    axis.set_xticks([])
    axis.set_yticks([])
    axis.spines[:].set_color("white")
    return axis.imshow(error, cmap=ERRORS, vmin=0, vmax=WORST, interpolation="antialiased")
