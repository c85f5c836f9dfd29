"""Quality of each reconstructor from few frames and from all (paper, `tab:reconchoice`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from fsel.core.files import File, Files, read_table, write_table, write_text
from fsel.core.split import Split
from fsel.evaluation.latex import captures_of, number, plain_table, printed, tex
from fsel.evaluation.summary import ALL_FRAMES, write_csv
from fsel.experiments.paper.time_quality import UNITS, cost_means, costs_alone
from fsel.experiments.paper.transfer import of_each
from fsel.metrics import Metrics, headings, units

METHOD = "less_is_more"


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
    own = picks[picks["method"] == METHOD].groupby(["k", "seed"])["frame"]
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
            rows[-1] += _cells(row, metrics)
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


def _cells(row: Mapping, metrics: Metrics) -> list[str]:
    if row["outcome"]:
        return [rf"\textit{{{row['outcome']}}}", "", ""]
    quality = "/".join(number(row[metric], metric) for metric in metrics)
    return [quality, f"{row['seconds']:.1f}", f"{row['peak_mb']:.0f}"]
