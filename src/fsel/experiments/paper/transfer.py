"""Frozen picks under other reconstructors (paper, Table 2, `tab:transferwopt`)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
import pandas as pd

from fsel.core.files import File, Files, write_text
from fsel.evaluation.captions import captures_of, printed
from fsel.evaluation.latex import difference, number, plain_table
from fsel.evaluation.summary import OUTCOME, summarise, write_csv
from fsel.evaluation.summary import differences as paired
from fsel.evaluation.sweep import LABELS, named, sweep_cells
from fsel.experiments.paper import crosscapture
from fsel.metrics import Metrics, headings
from fsel.stages.evaluate import evaluate

BASELINES = (*crosscapture.BASELINES, "nearest")
OURS = ("less_is_more", "fsel")
SHOWN = {name: LABELS[name] for name in (*BASELINES, *OURS)}
SEED = 0  # the one seed whose picks are reconstructed


def evaluate_transfer(
    folder: File,
    splits: Files,
    selections: Files,
    evaluations: Files,
    *,
    reconstruction: Mapping,
    metrics: Metrics,
    budgets: Sequence[int],
    config: str,
) -> None:
    """Reconstruct a capture from the picks that the table shows.

    Args:
        folder, splits, selections, evaluations, reconstruction, metrics: see
            `fsel.stages.evaluate`.
        budgets: whose picks are reconstructed.
    """
    evaluate(
        folder,
        splits,
        selections,
        evaluations,
        reconstruction=reconstruction,
        metrics=metrics,
        only={"method": list(SHOWN), "k": budgets, "seed": [SEED]},
        config=config,
    )


def of_each(evaluations: Files, names: Iterable[str]) -> dict[str, Files]:
    """Map each name to its part of the evaluations."""
    every = list(names)
    count = len(evaluations) // len(every)
    return {name: evaluations[at * count :][:count] for at, name in enumerate(every)}


def transfer(
    evaluations: Files,
    table: File,
    numbers: File,
    differences: File,
    *,
    problems: Sequence[str],
    reconstructors: Mapping[str, Mapping],
    budgets: Sequence[int],
    metrics: Metrics,
    facts: Mapping,
) -> None:
    """Write the table "Cross-reconstructor transfer of selected views".

    Args:
        evaluations: what `evaluate_transfer` wrote: all problems of the first
            reconstructor, then of the next.
        table, numbers: receive LaTeX, and reconstructor, method, k, metric, mean, ci_low, ci_high.
        differences: receives ours and fsel minus every other method, paired, with intervals.
        problems: `dataset/scene/draw0` of each evaluation of one reconstructor.
        reconstructors: name -> `reconstructor` and `long_side` to print, one block of rows each.
        budgets: one group of columns each.
    """
    each = of_each(evaluations, reconstructors)
    cells = {
        name: sweep_cells(named(problems, own), metrics, facts=facts) for name, own in each.items()
    }
    means = {name: summarise(own, metrics) for name, own in cells.items()}
    gaps = {name: paired(own, list(OURS), metrics) for name, own in cells.items()}
    every, ahead = (
        pd.concat(tables, names=["reconstructor"]).reset_index(0).drop(columns="dataset")
        for tables in (means, gaps)
    )
    write_csv(every, numbers)
    write_csv(ahead, differences)
    rows = []
    for name, own in reconstructors.items():
        rows.append([printed(own), *[""] * (3 * len(budgets))])
        for method, label in SHOWN.items():
            rows.append([label, *_cells(every, ahead, method, name, budgets, metrics)])
    head = ["Selector", *["/".join(headings(metrics)), "ours $-$", "fsel $-$"] * len(budgets)]
    groups = [(rf"$K{{=}}{k}$", 3) for k in budgets]
    text = caption(reconstructors, problems, facts)
    made = plain_table(head, rows, caption=text, label="tab:transferwopt", groups=groups)
    write_text(made, table)


def _cells(
    means: pd.DataFrame,
    gaps: pd.DataFrame,
    method: str,
    name: str,
    budgets: Sequence[int],
    metrics: Metrics,
) -> Iterator[str]:
    """Yield a row's cells of one reconstructor and every budget."""
    keyed = means.set_index(["reconstructor", "method", "k", "metric"])
    values, ended = keyed["mean"], keyed.get(OUTCOME)
    gaps = gaps[(gaps["metric"] == "psnr") & (gaps["reference"] == method)]
    paired = gaps.set_index(["reconstructor", "method", "k"])[["mean", "ci_low", "ci_high"]]
    for k in budgets:
        if np.isnan(values[name, method, k, "psnr"]):
            yield rf"\textit{{{ended[name, method, k, 'psnr']}}}"
        else:
            yield "/".join(number(values[name, method, k, metric], metric) for metric in metrics)
        for ours in OURS:
            yield "" if ours == method else difference(*paired.loc[(name, ours, k)])


def caption(reconstructors: Mapping[str, Mapping], problems: Sequence[str], facts: Mapping) -> str:
    """Describe the captures and reconstructors of the table, in LaTeX; arguments of `transfer`."""
    scenes = len({problem.rpartition("/")[0] for problem in problems})
    names = ", ".join(map(printed, reconstructors.values()))
    return (
        r"\textbf{Cross-reconstructor transfer of selected views.} The same picks under each "
        f"reconstructor ({names}); nothing is selected anew for any. Right of each cell: PSNR (dB) "
        "of ours and of fsel minus the row's, paired, with 95\\% intervals, bold where they "
        f"exclude zero. Means over {scenes} scenes, {len(problems)} draws of targets in all, and "
        f"one seed of the methods that have several. Captures: {captures_of(facts)}."
    )
