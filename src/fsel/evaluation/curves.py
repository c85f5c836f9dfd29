"""The figure of the search and the labels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from fsel.evaluation.figures import (
    COLORS,
    TEXT,
    footnote,
    name_axes,
    new_figure,
    save,
)
from fsel.evaluation.plan import draw_cameras

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.ticker import MaxNLocator


def search_and_labels(
    population: pd.DataFrame,
    plans: Mapping[str, Mapping],
    outputs: Sequence[str | Path],
    note: str,
) -> None:
    """The search's population over generations, and trajectories of labels from above.

    Args:
        population: generation, psnr, one row a distinct subset, and best: the PSNR of the fittest
            subset met until then.
        plans: title -> places (N, 2), targets (H,), picks (K,) frames in the order of the label.
        outputs: paths; their endings choose the format.
        note: what made the numbers.
    """
    figure = new_figure((TEXT, 2.1))
    axes = figure.subplots(1, 1 + len(plans), width_ratios=[1.3, *[1.0] * len(plans)])
    _population(axes[0], population)
    for axis, (title, plan) in zip(axes[1:], plans.items(), strict=True):
        shown = _trajectory(axis, title, plan)
    bar = figure.colorbar(shown, ax=list(axes[1:]), shrink=0.8, ticks=_whole_numbers())
    bar.set_label("step of the label", fontsize=7)
    bar.ax.tick_params(labelsize=6)
    footnote(figure, note)
    save(figure, outputs)


def _whole_numbers() -> MaxNLocator:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(integer=True)


def _population(axis: Axes, population: pd.DataFrame) -> None:
    axis.plot(population["generation"], population["psnr"], ".", color="0.6", markersize=3)
    best = population.groupby("generation")["best"].last()
    axis.step(best.index, best, where="post", color=COLORS[0], label="fittest so far")
    name_axes(axis, "generation that met it", "PSNR on the proxies (dB)")
    axis.xaxis.set_major_locator(_whole_numbers())
    axis.legend(fontsize=7)


def _trajectory(axis: Axes, title: str, plan: Mapping):
    places, picks = plan["places"], plan["picks"]
    draw_cameras(axis, places, plan["targets"])
    x, y = places[picks].T
    axis.plot(x, y, "-", color="0.5", linewidth=0.4, zorder=2)
    steps = np.arange(1, len(picks) + 1)
    shown = axis.scatter(x, y, c=steps, cmap="viridis", s=18, zorder=4)
    axis.set_title(title, fontsize=8)
    return shown
