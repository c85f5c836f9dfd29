"""Selection time against the PSNR that a search by reconstruction would still gain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from fsel.report.figures import save

METRIC = "psnr"


def gaps(cells: pd.DataFrame, *, reference: str, methods: Sequence[str]) -> pd.DataFrame:
    """PSNR of a reference minus that of each method, where both were measured.

    Args:
        cells: dataset, scene, draw, method, psnr at one budget.
        reference: the method to fall short of.
        methods: to compare, in order.

    Returns:
        method, gap in dB: means over draws, then scenes, then datasets.

    Raises:
        ValueError: when the reference was measured nowhere.
    """
    wide = cells.pivot(index=["dataset", "scene", "draw"], columns="method", values=METRIC)
    if reference not in wide:
        raise ValueError(
            f"no PSNR of {reference!r} at this budget among {sorted(wide.columns)}. Hint: set "
            "oracle.draws to 1 or more, and search.k to one of budgets"
        )
    behind = wide[list(methods)].rsub(wide[reference], axis=0).dropna()
    mean = behind.groupby(["dataset", "scene"]).mean().groupby("dataset").mean().mean()
    return mean.rename("gap").rename_axis("method").reset_index()


def draw(
    points: pd.DataFrame,
    labels: Mapping[str, str],
    ours: Sequence[str],
    outputs: Sequence[str | Path],
    *,
    xlabel: str,
    ylabel: str,
) -> None:
    """One labelled point a method; down and left is better.

    Args:
        points: method, seconds, gap.
        labels: method -> printed name.
        ours: methods set apart by colour.
        outputs: paths; their endings choose the format.
        xlabel, ylabel: of the axes.
    """
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axis = figure.subplots()
    axis.axhline(0, color="0.6", linewidth=0.8)
    axis.set_xscale("log")
    points = points.sort_values("gap", kind="stable").reset_index(drop=True)
    for i, (name, seconds, gap) in enumerate(points[["method", "seconds", "gap"]].to_numpy()):
        color = "tab:red" if name in ours else "tab:blue"
        axis.plot(seconds, gap, "o", color=color, markersize=4)
        # names stand beside the axes in the points' order, where they cannot overlap
        axis.annotate(
            labels[name],
            (seconds, gap),
            xytext=(1.06, (i + 0.5) / len(points)),
            textcoords="axes fraction",
            va="center",
            fontsize=7,
            color=color,
            arrowprops={
                "arrowstyle": "-",
                "color": "0.75",
                "linewidth": 0.5,
                "relpos": (0, 0.5),  # to the start of the name
            },
        )
    axis.set_xlabel(xlabel)
    axis.set_ylabel(ylabel)
    axis.tick_params(labelsize=8)
    save(figure, outputs)
