"""Speed against error of the selection methods."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence

import pandas as pd
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from fsel.core.files import File, Files, write_text
from fsel.core.problem import Problem
from fsel.evaluation.figures import TEXT, footnote, name_axes, new_figure, save
from fsel.evaluation.latex import note, plain_table
from fsel.evaluation.measuring import Run, learned_runs
from fsel.evaluation.summary import write_csv
from fsel.evaluation.sweep import BASELINES, LABELS, PLAIN, sweep_cells
from fsel.experiments.paper.time_quality import descriptor_seconds, selection_seconds
from fsel.selectors.baselines import METHODS
from fsel.selectors.policies import POLICIES

logger = logging.getLogger(__name__)


def speed_error(
    folder: File,
    split: File,
    weights: Files,
    evaluations: Files,
    oracles: Files,
    table: File,
    numbers: File,
    figures: Files,
    *,
    problems: Sequence[str],
    k: int,
    appearance: Mapping,
    facts: Mapping,
) -> None:
    """Time every method on one problem, and draw it against its gap to the search over `problems`.

    Args:
        folder, split: the described capture and the targets of the problem that is timed.
        weights: scorers of the learned methods; the first of each is timed.
        table, numbers: receive LaTeX, and method, gap in dB, and seconds with their two parts.
        facts: as of `fsel.evaluation.latex.note`.
    """
    problem = Problem.load(folder, split)
    timed = method_seconds(problem, weights, k, appearance)
    cells = sweep_cells([*problems, *problems], [*evaluations, *oracles], facts={})
    methods = gaps(cells[cells["k"] == k], reference="search", methods=list(timed.index))
    methods = methods.join(timed, on="method")
    selected = f"{k} of {len(problem.observed)} frames"
    draw(methods, figures, selected=selected, k=k, facts=facts)
    write_csv(methods, numbers)
    write_text(_table(methods, selected, k), table)


def method_seconds(problem: Problem, weights: Files, k: int, appearance: Mapping) -> pd.DataFrame:
    """Return method -> seconds to select k frames, and of them `descriptors` and `selection`."""
    learned = [run for run in learned_runs(weights) if run.seed == 0]
    described = descriptor_seconds(problem, appearance)
    rows = {}
    for run in [*(Run(METHODS[name], 0) for name in BASELINES), *learned]:
        rows[run.method.name] = selection_seconds(problem, run, k, described)
        logger.info("%s: %.4f + %.4f s", run.method.name, *rows[run.method.name])
    timed = pd.DataFrame.from_dict(rows, orient="index", columns=["descriptors", "selection"])
    return timed.assign(seconds=timed.sum(axis="columns"))


def _table(methods: pd.DataFrame, selected: str, k: int) -> str:
    return plain_table(
        ["Selection", "ms", "gap (dB)"],
        [
            [LABELS[row.method], f"{1e3 * row.seconds:,.3g}", f"{row.gap:.2f}"]
            for row in methods.sort_values("gap", kind="stable").itertuples()
        ],
        caption=rf"\textbf{{Speed against error: methods.}} Time to select {selected} on one "
        "thread, with the descriptors that a method reads (FisherRF and COVER: with their "
        rf"reconstructions), and PSNR behind the genetic search at $K={k}$.",
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


def draw(methods: pd.DataFrame, outputs: Files, *, selected: str, k: int, facts: Mapping) -> None:
    """Draw dB lost against seconds, on a logarithmic axis, of every method."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    figure = new_figure((TEXT / 2, 3.6))
    axis = figure.subplots(subplot_kw={"xscale": "log"})
    _draw_methods(axis, methods)
    name_axes(axis, f"seconds to select {selected}", f"dB behind the search, K = {k}")
    axis.xaxis.set_major_locator(LogLocator(subs=(1,)))
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.xaxis.set_minor_formatter(NullFormatter())
    footnote(figure, note(facts))
    save(figure, outputs)


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
