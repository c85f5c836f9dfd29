"""Tables of methods in which those are bold that lead every other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pandas as pd

from fsel.metrics import Metrics
from fsel.report.latex import number
from fsel.report.summary import differences, leaders, summarise

KEYS = ["dataset", "method", "k", "metric"]


def with_leads(cells: pd.DataFrame, methods: Sequence[str], metrics: Metrics) -> pd.DataFrame:
    """Means as of `summarise`, and `leads`: one of some methods is ahead of every other.

    It is ahead where each paired 95 % interval excludes zero.
    """
    means = summarise(cells, metrics)
    gaps = differences(cells, methods, metrics)
    ahead = {(name, *key) for name, part in gaps.groupby("dataset") for key in leaders(part)}
    keys = zip(*(means[key] for key in KEYS), strict=True)
    return means.assign(leads=[key in ahead for key in keys])


def led_rows(
    means: pd.DataFrame,
    labels: Mapping[str, str],
    columns: Sequence[tuple[str, int]],
    metrics: Metrics,
) -> list[list[str]]:
    """A row a method: its label, and for each dataset and budget a cell a metric.

    Args:
        means: see `with_leads`.
        labels: method -> label, in order.
        columns: dataset and budget of each group of cells.
        metrics: of a group.
    """
    values = means.set_index(KEYS)
    cells = [(dataset, k, metric) for dataset, k in columns for metric in metrics]
    return [
        [label, *(_cell(values.loc[(dataset, name, k, m)], m) for dataset, k, m in cells)]
        for name, label in labels.items()
    ]


def _cell(row: pd.Series, metric: str) -> str:
    text = number(row["mean"], metric)
    return rf"\textbf{{{text}}}" if row["leads"] else text
