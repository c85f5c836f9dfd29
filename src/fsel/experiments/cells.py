"""Cells of a table of trials, and rows in which those are bold that lead every other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pandas as pd

from fsel.core.files import Files, read_table
from fsel.evaluation.latex import bold_if, number
from fsel.evaluation.summary import differences, draw_means, leaders, summarise
from fsel.evaluation.sweep import place_of
from fsel.metrics import Metrics

Scenes = Sequence[tuple[str, str]]
"""Dataset and scene of each."""
KEYS = ["dataset", "method", "k", "metric"]
GAP = ["difference", "difference_low", "difference_high"]


def cells_of(
    scenes: Scenes,
    evaluations: Files,
    metrics: Metrics,
    facts: Mapping,
    by: Sequence[str] = ("draw",),
) -> pd.DataFrame:
    """Return a row for each trial, method and budget: means over targets, then over seeds.

    Args:
        facts: see `fsel.evaluation.sweep.place_of`.
        by: columns of the trials.

    Returns:
        method, k, the metrics, dataset, scene (`dataset/scene`), place and the columns of `by`.
    """
    tables = []
    for (dataset, scene), path in zip(scenes, evaluations, strict=True):
        name = f"{dataset}/{scene}"
        where = {"dataset": dataset, "scene": name, "place": place_of(name, facts)}
        for key, part in read_table(path).groupby(list(by)):
            columns = where | dict(zip(by, key, strict=True))
            tables.append(draw_means(part, metrics).assign(**columns))
    return pd.concat(tables, ignore_index=True)


def with_leads(cells: pd.DataFrame, methods: Sequence[str], metrics: Metrics) -> pd.DataFrame:
    """Return the means of `summarise`, and `leads`: one of some methods is ahead of every other.

    It is ahead where each paired 95 % interval excludes zero.
    """
    means = summarise(cells, metrics)
    gaps = differences(cells, methods, metrics)
    ahead = {(name, *key) for name, part in gaps.groupby("dataset") for key in leaders(part)}
    keys = zip(*(means[key] for key in KEYS), strict=True)
    return means.assign(leads=[key in ahead for key in keys])


def against(cells: pd.DataFrame, reference: str) -> pd.DataFrame:
    """Return every method's mean PSNR at one budget, and its paired difference to a reference.

    Returns:
        k, mean, ci_low, ci_high, n, and `GAP` (NaN for the reference itself) by method.
    """
    gaps = differences(cells, cells["method"].unique().tolist(), ["psnr"])
    gaps = gaps[gaps["reference"] == reference].set_index("method")[["mean", "ci_low", "ci_high"]]
    gaps.columns = pd.Index(GAP)
    return summarise(cells, ["psnr"]).set_index("method").join(gaps)


def led_rows(
    means: pd.DataFrame,
    labels: Mapping[str, str],
    columns: Sequence[tuple[str, int]],
    metrics: Metrics,
) -> list[list[str]]:
    """Return a row for each method: its label, then a cell for each dataset, budget and metric.

    Args:
        means: see `with_leads`.
        labels: method -> label, in order.
        columns: dataset and budget of each group of cells.
    """
    values = means.set_index(KEYS)
    cells = [(dataset, k, metric) for dataset, k in columns for metric in metrics]
    rows = []
    for name, label in labels.items():
        found = [(values.loc[(dataset, name, k, metric)], metric) for dataset, k, metric in cells]
        texts = [bold_if(row["leads"], number(row["mean"], metric)) for row, metric in found]
        rows.append([label, *texts])
    return rows
