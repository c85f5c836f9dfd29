"""Gain of a method over the strongest baseline, by dataset and budget (paper, Figure 4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from fsel.evaluation.figures import TEXT, new_figure, save
from fsel.evaluation.statistics import ahead_of_all, holm

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Normalize

METRIC = "psnr"
ERROR = 0.05
COLUMNS = 2  # panels side by side
GAINS = "YlGnBu"  # the darker, the better, also in grey
WHITE = 0.55  # of the scale: writing on what is darker is white


def gains(
    summary: pd.DataFrame,
    differences: pd.DataFrame,
    *,
    method: str,
    baselines: Sequence[str],
    datasets: Sequence[str],
    budgets: Sequence[int],
) -> pd.DataFrame:
    """Compute a method's PSNR gain over the baseline with the highest mean in each cell.

    The baseline is chosen on the scenes that it is compared on, which favours it. The mark needs no
    choice: the method is ahead of every baseline, by Holm's correction over all cells.

    Args:
        summary: see `fsel.evaluation.summary.summarise`.
        differences: see `fsel.evaluation.summary.differences`.
        method: whose gain.
        baselines: methods to be strongest among.
        datasets: in order.
        budgets: in order.

    Returns:
        dataset, k, reference (the strongest), gain in dB, n (places), p (of being ahead of every
        baseline, corrected for the number of cells), significant (p below 0.05).
    """
    here = summary[(summary["metric"] == METRIC) & summary["method"].isin(baselines)]
    strongest = here.loc[here.groupby(["dataset", "k"])["mean"].idxmax()]
    strongest = strongest.set_index(["dataset", "k"])["method"]
    paired = differences[(differences["metric"] == METRIC) & (differences["method"] == method)]
    paired = paired[paired["reference"].isin(baselines)]
    paired = paired.set_index(["dataset", "k", "reference"]).sort_index()
    rows = []
    for dataset in datasets:
        for k in budgets:
            rivals = paired.loc[(dataset, k)]
            row = rivals.loc[strongest[dataset, k]]
            p = ahead_of_all(rivals["mean"].to_numpy(), rivals["p"].to_numpy())
            rows.append((dataset, k, strongest[dataset, k], row["mean"], int(row["n"]), p))
    table = pd.DataFrame(rows, columns=["dataset", "k", "reference", "gain", "n", "p"])
    table["p"] = holm(table["p"].to_numpy())
    return table.assign(significant=table["p"] < ERROR)


def draw(
    panels: Mapping[str, pd.DataFrame],
    labels: Mapping[str, str],
    outputs: Sequence[str | Path],
    reconstructor: str = "",
) -> None:
    """Draw one panel a method, on one colour scale from the least gain, or zero, to the greatest.

    Args:
        panels: title -> what `gains` returned; all over the same datasets and budgets.
        labels: dataset -> printed name.
        outputs: paths; their endings choose the format.
        reconstructor: to be named under the panels.
    """
    from matplotlib.colors import Normalize

    gained = pd.concat([panel["gain"] for panel in panels.values()])
    scale = Normalize(min(gained.min(), 0.0), max(gained.max(), 0.1))
    lines = -(-len(panels) // COLUMNS)
    size = (TEXT, 0.5 + lines * (0.6 + 0.3 * len(labels)))
    figure = new_figure(size)
    axes = figure.subplots(lines, COLUMNS, squeeze=False, sharey=True).ravel()
    for axis, (title, panel) in zip(axes, panels.items(), strict=True):
        image = _panel(axis, panel, labels, scale)
        axis.set_title(title, fontsize=8)
    bar = figure.colorbar(image, ax=list(axes), shrink=0.9)
    bar.set_label("PSNR gain (dB)", fontsize=8)
    bar.ax.axhline(0, color="black", linewidth=0.8)
    bar.ax.tick_params(labelsize=7)
    made = f"; reconstructor: {reconstructor}" if reconstructor else ""
    figure.supxlabel(
        "number: over the baseline with the highest mean of the cell; n: scenes; bold and *: ahead "
        f"of every baseline\n(paired t-tests on scene means, 5%, Holm over a panel's cells){made}",
        fontsize=7,
    )
    save(figure, outputs)


def _panel(axis: Axes, panel: pd.DataFrame, labels: Mapping[str, str], scale: Normalize):
    grid = panel.pivot(index="dataset", columns="k", values="gain").loc[list(labels)]
    image = axis.imshow(grid, cmap=GAINS, norm=scale, aspect="auto")
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
                color="white" if scale(value) > WHITE else "black",
            )
    axis.set_xticks(np.arange(len(grid.columns)), [f"K={k}" for k in grid.columns], fontsize=7)
    counts = panel.groupby("dataset")["n"].first()
    names = [f"{label} (n={counts[name]})" for name, label in labels.items()]
    axis.set_yticks(np.arange(len(labels)), names, fontsize=8)
    axis.tick_params(length=0)
    return image
