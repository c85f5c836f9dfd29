"""Speed against error: methods, settings of the reconstructor, evaluations of a search."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from fsel.evaluation.figures import COLORS, MARKERS, TEXT, name_axes, new_figure, save, style
from fsel.evaluation.sweep import PLAIN
from fsel.selectors.policies import POLICIES

METRIC = "psnr"
SEARCHES = {
    "search": "genetic search, evaluation scenes",
    "random_search": "random search, evaluation scenes",
    "labels": "genetic search, labels",
}


def gaps(cells: pd.DataFrame, *, reference: str, methods: Sequence[str]) -> pd.DataFrame:
    """Compute the PSNR of a reference minus that of each method, where both were measured.

    Args:
        cells: dataset, scene, draw, method, psnr at one budget.

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
    methods: pd.DataFrame,
    settings: pd.DataFrame,
    curves: pd.DataFrame,
    outputs: Sequence[str | Path],
    *,
    selected: str,
    k: int,
) -> None:
    """Draw methods, the reconstructor's settings (depth, PSNR), and evaluations of a search.

    Args:
        methods: method, seconds, gap.
        settings: setting, value, default, seconds, depth_error, psnr.
        curves: search, evaluations, gap.
        selected: what was timed, in words.
        k: frames that the search picks.
    """
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    figure = new_figure((TEXT, 6.2))
    (first, third), (second, fourth) = figure.subplots(2, 2)
    _draw_methods(first, methods)
    first.set_title("a  methods", loc="left", fontsize=9, fontweight="bold")
    name_axes(first, f"seconds to select {selected}", f"PSNR behind the search (dB), K = {k}")
    for number, (name, part) in enumerate(curves.groupby("search", sort=False)):
        line = style(number) | {"marker": ""}
        second.plot(part["evaluations"], part["gap"], label=SEARCHES[name], **line)
    name_axes(second, "subsets reconstructed", "PSNR behind the search's end (dB)")
    second.set_ylim(bottom=0)
    second.legend(fontsize=7, frameon=False)
    second.set_title("c  the search", loc="left", fontsize=9, fontweight="bold")
    drawn = {third: ("depth_error", "depth error (%)", 100), fourth: ("psnr", "PSNR (dB)", 1)}
    for letter, (axis, (column, label, unit)) in zip("bd", drawn.items(), strict=True):
        _draw_settings(axis, settings.assign(value_of=unit * settings[column]))
        title = f"{letter}  the reconstructor"
        axis.set_title(title, loc="left", fontsize=9, fontweight="bold")
        name_axes(axis, "seconds, nothing cached", label)
    handles, names = third.get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower right", ncols=6, fontsize=7, frameon=False)
    for axis in figure.axes:
        if axis.get_xscale() == "log":
            low, high = axis.get_xlim()
            axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 30 * low else (1,)))
            axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.xaxis.set_minor_formatter(NullFormatter())
    save(figure, outputs)


def _draw_settings(axis, settings: pd.DataFrame) -> None:
    """Draw a colour and a marker a setting, its values tied to the default, which is a star."""
    default = settings[settings["default"]].iloc[-1]
    for i, (name, part) in enumerate(settings.groupby("setting", sort=False)):
        changed = part[~part["default"]].sort_values("seconds")
        color, marker = COLORS[i], MARKERS[i]
        places = (changed["seconds"], changed["value_of"])
        axis.plot(*places, marker, color=color, ms=4, label=name)
        for row in changed.itertuples():
            line = (row.seconds, default["seconds"]), (row.value_of, default["value_of"])
            axis.plot(*line, "-", color=color, linewidth=0.6, alpha=0.5)
            beside = {"xytext": (3, 3), "textcoords": "offset points"}
            axis.annotate(row.value, (row.seconds, row.value_of), **beside, fontsize=6, color=color)
    axis.plot(default["seconds"], default["value_of"], "k*", markersize=11, label="default")
    axis.set_xscale("log")
    axis.margins(x=0.1)


def _draw_methods(axis, points: pd.DataFrame) -> None:
    """Draw one labelled point a method; down and left is better."""
    axis.axhline(0, color="0.6", linewidth=0.8)
    axis.set_xscale("log")
    points = points.sort_values("gap", kind="stable").reset_index(drop=True)
    for i, (name, seconds, gap) in enumerate(points[["method", "seconds", "gap"]].to_numpy()):
        color, marker = (COLORS[0], "s") if name in POLICIES else (COLORS[1], "o")
        axis.plot(seconds, gap, marker, color=color, markersize=4)
        # names stand beside the axes in the points' order, where they cannot overlap
        axis.annotate(
            PLAIN[name],
            (seconds, gap),
            xytext=(1.06, (i + 0.5) / len(points)),
            textcoords="axes fraction",
            va="center",
            fontsize=7,
            color=color,
            fontweight="bold" if name in POLICIES else "normal",
            # to the start of the name
            arrowprops={"arrowstyle": "-", "color": "0.75", "linewidth": 0.5, "relpos": (0, 0.5)},
        )
