"""Gain of a method over the strongest baseline, by dataset and budget (paper, Figure 4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fsel.report.figures import save

METRIC = "psnr"


def gains(
    summary: pd.DataFrame,
    differences: pd.DataFrame,
    *,
    method: str,
    baselines: Sequence[str],
    datasets: Sequence[str],
    budgets: Sequence[int],
) -> pd.DataFrame:
    """PSNR gain of a method over the baseline with the highest mean in each cell.

    Args:
        summary: see `fsel.report.summary.summarise`.
        differences: see `fsel.report.summary.differences`.
        method: whose gain.
        baselines: methods to be strongest among.
        datasets: in order.
        budgets: in order.

    Returns:
        dataset, k, reference (the strongest), gain in dB, significant (the paired 95% interval
        excludes zero).
    """
    here = summary[(summary["metric"] == METRIC) & summary["method"].isin(baselines)]
    strongest = here.loc[here.groupby(["dataset", "k"])["mean"].idxmax()]
    strongest = strongest.set_index(["dataset", "k"])["method"]
    paired = differences[(differences["metric"] == METRIC) & (differences["method"] == method)]
    paired = paired.set_index(["dataset", "k", "reference"]).sort_index()
    rows = []
    for dataset in datasets:
        for k in budgets:
            row = paired.loc[(dataset, k, strongest[dataset, k])]
            significant = row["ci_low"] > 0 or row["ci_high"] < 0
            rows.append((dataset, k, strongest[dataset, k], row["mean"], bool(significant)))
    return pd.DataFrame(rows, columns=["dataset", "k", "reference", "gain", "significant"])


def draw(
    panels: Mapping[str, pd.DataFrame],
    labels: Mapping[str, str],
    outputs: Sequence[str | Path],
    judge: str = "",
) -> None:
    """One panel a method, on one colour scale centred at zero.

    Args:
        panels: title -> what `gains` returned; all over the same datasets and budgets.
        labels: dataset -> printed name.
        outputs: paths; their endings choose the format.
        judge: the reconstructor to be named under the panels.
    """
    matplotlib.use("Agg")
    limit = max(float(panel["gain"].abs().max()) for panel in panels.values()) or 1.0
    rows = len(labels)
    figure = Figure(figsize=(1.6 + 3.1 * len(panels), 1.5 + 0.38 * rows), layout="constrained")
    axes = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
    for axis, (title, panel) in zip(axes, panels.items(), strict=True):
        image = _panel(axis, panel, labels, limit)
        axis.set_title(title, fontsize=9)
    bar = figure.colorbar(image, ax=list(axes), shrink=0.9)
    bar.set_label("PSNR gain (dB)", fontsize=8)
    bar.ax.tick_params(labelsize=7)
    made = f"; reconstructor: {judge}" if judge else ""
    figure.supxlabel(f"bold and *: the paired 95% interval excludes zero{made}", fontsize=7)
    save(figure, outputs)


def _panel(axis: Axes, panel: pd.DataFrame, labels: Mapping[str, str], limit: float):
    grid = panel.pivot(index="dataset", columns="k", values="gain").loc[list(labels)]
    image = axis.imshow(grid, cmap="RdBu", vmin=-limit, vmax=limit, aspect="auto")
    marked = panel.set_index(["dataset", "k"])["significant"]
    for y, dataset in enumerate(labels):
        for x, k in enumerate(grid.columns):
            value, sure = grid.loc[dataset, k], marked[dataset, k]
            axis.text(
                x,
                y,
                f"{value:+.2f}{'*' if sure else ''}",
                ha="center",
                va="center",
                fontsize=7,
                fontweight="bold" if sure else "normal",
                color="white" if abs(value) > 0.65 * limit else "black",
            )
    axis.set_xticks(np.arange(len(grid.columns)), [f"K={k}" for k in grid.columns], fontsize=7)
    axis.set_yticks(np.arange(len(labels)), list(labels.values()), fontsize=8)
    axis.tick_params(length=0)
    return image
