"""Other reconstructors: frozen picks under each (paper, Table 2, `tab:transferwopt`), and each with
few frames and with all (`tab:reconchoice`)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from fsel.core.files import File, Files, read_table, write_table, write_text
from fsel.core.split import Split
from fsel.evaluation.latex import captures_of, difference, number, plain_table, printed, tex
from fsel.evaluation.summary import ALL_FRAMES, OUTCOME, summarise, write_csv
from fsel.evaluation.summary import differences as paired
from fsel.evaluation.sweep import LABELS, sweep_cells
from fsel.experiments.paper import crosscapture
from fsel.experiments.paper.time_quality import UNITS, cost_means, costs_alone
from fsel.metrics import Metrics, headings, units
from fsel.stages.evaluate import evaluate

BASELINES = (*crosscapture.BASELINES, "nearest")
OURS = ("less_is_more", "fsel")
SHOWN = {name: LABELS[name] for name in (*BASELINES, *OURS)}
CHOSEN = "less_is_more"  # whose picks `reconchoice` reconstructs from


def evaluate_transfer(
    folder: File,
    splits: Files,
    selections: Files,
    evaluations: Files,
    *,
    reconstruction: Mapping,
    metrics: Metrics,
    budgets: Sequence[int],
    seeds: Sequence[int],
    config: str,
) -> None:
    """Reconstruct a capture from the picks that the table shows; see `fsel.stages.evaluate`."""
    only = {"method": list(SHOWN), "k": budgets, "seed": seeds}
    how: dict[str, Any] = {"reconstruction": reconstruction, "metrics": metrics, "config": config}
    evaluate(folder, splits, selections, evaluations, only=only, **how)


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
    seeds: Sequence[int],
    metrics: Metrics,
    facts: Mapping,
) -> None:
    """Write the table "Cross-reconstructor transfer of selected views".

    `evaluations` are of all problems of the first reconstructor, then of the next; `differences`
    receives ours and fsel minus every other method, paired; `reconstructors` maps a name to what is
    printed.
    """
    each = of_each(evaluations, reconstructors)
    cells = {name: sweep_cells(problems, own, metrics, facts=facts) for name, own in each.items()}
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
        keys = ["method", "k", "metric"]
        values = every[every["reconstructor"] == name].set_index(keys).sort_index()
        paired_gaps = ahead[ahead["reconstructor"] == name].set_index([*keys, "reference"])
        for method, label in SHOWN.items():
            rows.append([label])
            for k in budgets:
                rows[-1] += _cells(values.loc[(method, k)], paired_gaps, method, k, metrics)
    head = ["Selector", *["/".join(headings(metrics)), "ours $-$", "fsel $-$"] * len(budgets)]
    groups = [(rf"$K{{=}}{k}$", 3) for k in budgets]
    text = caption(reconstructors, problems, seeds, facts)
    made = plain_table(head, rows, caption=text, label="tab:transferwopt", groups=groups)
    write_text(made, table)


def _cells(
    values: pd.DataFrame, gaps: pd.DataFrame, method: str, k: int, metrics: Metrics
) -> Iterator[str]:
    """Yield a method's cells of one reconstructor and budget: metrics, and both differences."""
    if np.isnan(values.loc["psnr", "mean"]):
        yield rf"\textit{{{values.loc['psnr', OUTCOME]}}}"
    else:
        yield "/".join(number(values.loc[metric, "mean"], metric) for metric in metrics)
    for ours in OURS:
        row = gaps.loc[(ours, k, "psnr", method)] if ours != method else None
        yield "" if row is None else difference(row["mean"], row["ci_low"], row["ci_high"])


def caption(
    reconstructors: Mapping[str, Mapping],
    problems: Sequence[str],
    seeds: Sequence[int],
    facts: Mapping,
) -> str:
    """Describe the captures and reconstructors of the table, in LaTeX; arguments of `transfer`."""
    scenes = len({problem.rpartition("/")[0] for problem in problems})
    names = ", ".join(map(printed, reconstructors.values()))
    return (
        r"\textbf{Cross-reconstructor transfer of selected views.} The same picks under each "
        f"reconstructor ({names}); nothing is selected anew for any. Right of each cell: PSNR (dB) "
        "of ours and of fsel minus the row's, paired, with 95\\% intervals, bold where they "
        f"exclude zero. Means over {scenes} scenes, {len(problems)} draws of targets in all, and "
        f"{len(seeds)} of the seeds of methods that have several. Captures: {captures_of(facts)}."
    )


def evaluate_reconchoice(
    folder: File,
    split: File,
    selections: File,
    evaluation: File,
    *,
    reconstruction: Mapping,
    metrics: Metrics,
    budgets: Sequence[int],
    seeds: Sequence[int],
    memory: int,
    config: str,
) -> None:
    """Measure quality, seconds and memory with our picks and with all frames of one draw, each in a
    process that may take `memory` bytes, into `costs_alone`'s columns."""
    picks = read_table(selections)
    own = picks[picks["method"] == CHOSEN].groupby(["k", "seed"])["frame"]
    made = [(k, seed) for k in budgets for seed in seeds if (k, seed) in own.groups]
    subsets = [(k, own.get_group((k, seed)).to_numpy(np.int64)) for k, seed in made]
    subsets += [(ALL_FRAMES, picks["frame"][picks["method"] == "all"].to_numpy(np.int64))]
    targets, alone = Split.load(split).targets, {"repeats": 1, "memory": memory}
    table = costs_alone(folder, subsets, targets, reconstruction, metrics, **alone)
    write_table(table, evaluation, units=units(metrics) | UNITS, config=config)


def reconchoice(
    evaluations: Files,
    table: File,
    numbers: File,
    *,
    problems: Sequence[str],
    reconstructors: Mapping[str, Mapping],
    metrics: Metrics,
    memory: int,
    facts: Mapping,
) -> None:
    """Write the table "Comparison across reconstructors", a block of columns each; `evaluations`
    are of all problems of the first, then of the next."""
    each = of_each(evaluations, reconstructors)
    parts = {name: cost_means(own, metrics) for name, own in each.items()}
    means = pd.concat(parts, names=["reconstructor"]).reset_index()
    write_csv(means, numbers)
    rows = []
    for k, part in means.groupby("k", sort=False):
        rows.append(["all frames" if k == ALL_FRAMES else f"$K{{=}}{k}$"])
        for row in part.set_index("reconstructor").loc[list(reconstructors)].to_dict("records"):
            rows[-1] += _cells_of_costs(row, metrics)
    head = ["Input", *["/".join(headings(metrics)), "s", "MB"] * len(reconstructors)]
    groups = [(printed(own), 3) for own in reconstructors.values()]
    scenes = len({problem.rpartition("/")[0] for problem in problems})
    text = (
        r"\textbf{Comparison across reconstructors.} The picks of ours and all candidates of "
        f"{scenes} scenes, {len(problems)} draws of targets in all. Processor "
        "seconds of fitting and rendering, and the peak of memory above the idle process; each in "
        f"a process of its own, which may take {memory / 1e9:.3g}~GB. {_on_gpus(means)}"
        f"Captures: {captures_of(facts)}."
    )
    made = plain_table(head, rows, caption=text, label="tab:reconchoice", groups=groups)
    write_text(made, table)


def _on_gpus(means: pd.DataFrame) -> str:
    """Say which reconstructors work on GPUs, and what their costs are."""
    own = means[~means["device"].isin(["cpu", ""])]
    if own.empty:
        return ""
    devices = own.groupby("reconstructor", sort=False)["device"].max()
    names = ", ".join(
        rf"\texttt{{{tex(name)}}} ({tex(device)})" for name, device in devices.items()
    )
    return f"On a GPU, seconds by the clock and memory of the GPU: {names}. "


def _cells_of_costs(row: Mapping, metrics: Metrics) -> list[str]:
    if row["outcome"]:
        return [rf"\textit{{{row['outcome']}}}", "", ""]
    quality = "/".join(number(row[metric], metric) for metric in metrics)
    return [quality, f"{row['seconds']:.1f}", f"{row['peak_mb']:.0f}"]
