"""Speed against error: of the methods, and of the reconstructor's settings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pandas as pd
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from fsel.core.files import File, Files, write_text
from fsel.evaluation.figures import MARKERS, TEXT, footnote, name_axes, new_figure, save
from fsel.evaluation.latex import note, plain_table
from fsel.evaluation.summary import write_csv
from fsel.evaluation.sweep import LABELS, PLAIN, sweep_cells
from fsel.selectors.policies import POLICIES


def speed_error(
    times: File,
    settings: File,
    evaluations: Files,
    oracles: Files,
    table: File,
    numbers: File,
    figures: Files,
    *,
    problems: Sequence[str],
    k: int,
    facts: Mapping,
) -> None:
    """Draw methods and settings, and write the table of methods; `times` is what `selection_time`
    wrote, whose smallest pool is drawn; `facts` as of `fsel.evaluation.latex.note`."""
    timed = pd.read_csv(times)
    timed = timed[timed["pool"] == timed["pool"].min()].set_index("method")
    cells = sweep_cells([*problems, *problems], [*evaluations, *oracles], facts={})
    methods = gaps(cells[cells["k"] == k], reference="search", methods=list(timed.index))
    methods["seconds"] = methods["method"].map(timed["descriptors"] + timed["selection"])
    swept = pd.read_csv(settings, dtype={"value": str})
    selected = "{} of {} frames".format(*timed[["k", "pool"]].iloc[0])
    draw(methods, swept, figures, selected=selected, k=k, facts=facts)
    every = pd.concat([methods, swept], keys=["methods", "settings"])
    every = every.droplevel(1).rename_axis("panel").reset_index()
    write_csv(every, numbers)
    write_text(_table(methods, selected, k), table)


def _table(methods: pd.DataFrame, selected: str, k: int) -> str:
    return plain_table(
        ["Selection", "ms", "gap (dB)"],
        [
            [LABELS[row.method], f"{1e3 * row.seconds:,.3g}", f"{row.gap:.2f}"]
            for row in methods.sort_values("gap", kind="stable").itertuples()
        ],
        caption=rf"\textbf{{Speed against error: methods.}} Time to select {selected}, descriptors "
        rf"included, and PSNR behind the genetic search at $K={k}$.",
        label="tab:speed_methods",
    )


def gaps(cells: pd.DataFrame, *, reference: str, methods: Sequence[str]) -> pd.DataFrame:
    """Compute the mean gap in dB of each method to a reference, where both were measured: over
    draws, then scenes, then datasets."""
    wide = cells.pivot(index=["dataset", "scene", "draw"], columns="method", values="psnr")
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
    outputs: Files,
    *,
    selected: str,
    k: int,
    facts: Mapping,
) -> None:
    """Draw dB lost against seconds, on a logarithmic axis, of every method and setting."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    figure = new_figure((TEXT, 3.6))
    left, right = figure.subplots(1, 2, width_ratios=[1, 1.15], subplot_kw={"xscale": "log"})
    _draw_methods(left, methods)
    name_axes(left, f"seconds to select {selected}", f"dB behind the search, K = {k}")
    _draw_settings(right, settings)
    name_axes(right, "seconds to reconstruct and render", "dB lost to the default setting")
    titles = {left: "selection methods", right: "settings of splats, one changed at a time"}
    for axis, title in titles.items():
        axis.set_title(title, loc="left", fontsize=8)
        low, high = axis.get_xlim()
        axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 30 * low else (1,)))
        axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.xaxis.set_minor_formatter(NullFormatter())
    footnote(figure, note(facts))
    save(figure, outputs)


def _draw_settings(axis, settings: pd.DataFrame) -> None:
    """Draw a marker a setting, its values tied to the default, which is a star."""
    default = settings[settings["default"]].iloc[-1]
    beside = (((4, 3), "left"), ((4, -8), "left"), ((-4, 2), "right"))
    for i, (name, part) in enumerate(settings.groupby("setting", sort=False)):
        changed = part[~part["default"]].sort_values("seconds")
        lost = default["psnr"] - changed["psnr"]
        for row, gap in zip(changed.itertuples(), lost, strict=True):
            axis.plot((row.seconds, default["seconds"]), (gap, 0), "-", color="0.8", linewidth=0.6)
            if abs(gap) < 0.12 and 0.7 < row.seconds / default["seconds"] < 1.4:
                continue  # under the star; the table has it
            offset, side = beside[i % len(beside)]
            place = {"xytext": offset, "textcoords": "offset points", "ha": side}
            axis.annotate(row.value, (row.seconds, gap), **place, fontsize=6)
        face = "white" if i % 2 else "0.4"
        style = {"markerfacecolor": face, "markeredgecolor": "black", "markersize": 5}
        axis.plot(changed["seconds"], lost, MARKERS[i], linestyle="none", label=name, **style)
    axis.plot(default["seconds"], 0, "k*", markersize=11, label="default")
    axis.legend(fontsize=6, frameon=False)
    axis.margins(x=0.12)


def _draw_methods(axis, points: pd.DataFrame) -> None:
    """Draw one labelled point a method; down and left is better."""
    axis.axhline(0, color="0.6", linewidth=0.8)
    ours = [name in POLICIES for name in points["method"]]
    for own, seconds, gap in zip(ours, points["seconds"], points["gap"], strict=True):
        axis.plot(seconds, gap, "s" if own else "o", color="black" if own else "0.5", ms=4)
    axis.autoscale_view()
    marks = points[["seconds", "gap"]].to_numpy()
    at = axis.transAxes.inverted().transform(axis.transData.transform(marks))
    places = [(1.06, 1 - (i + 0.5) / len(points)) for i in range(len(points))]
    # names stand beside the axes; of all ways to lead there, the shortest has no two that cross
    _, chosen = linear_sum_assignment(cdist(at, places))
    for name, own, point, place in zip(points["method"], ours, marks, chosen, strict=True):
        axis.annotate(
            PLAIN[name],
            point,
            xytext=places[place],
            textcoords="axes fraction",
            va="center",
            fontsize=6.5,
            fontweight="bold" if own else "normal",
            # to the start of the name
            arrowprops={"arrowstyle": "-", "color": "0.75", "linewidth": 0.5, "relpos": (0, 0.5)},
        )
