"""The heatmap of gains over the strongest baseline."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from fsel.report import heatmap as report
from fsel.report.numbers import read_csv
from fsel.report.sweep import BASELINES
from fsel.selector.policies import POLICIES

PANELS = ("fsel", "ours")


def heatmap(
    numbers: str | Path,
    differences: str | Path,
    figures: Sequence[str | Path],
    *,
    datasets: Mapping[str, str],
    budgets: Sequence[int],
    judge: str = "",
) -> None:
    """Gain of fsel and of ours over the strongest baseline, from the sweep's numbers.

    Args:
        numbers, differences: what `fsel.stages.ksweep` wrote.
        figures: receive the figure, in the format of each one's ending.
        datasets: name -> printed label, in order.
        budgets: columns.
        judge: the reconstructor, where it is not the first; it is named under the figure.
    """
    means, gaps = read_csv(numbers), read_csv(differences)
    panels = {}
    for method in PANELS:
        title = f"{POLICIES[method].label}: gain over the strongest baseline"
        panels[title] = report.gains(
            means,
            gaps,
            method=method,
            baselines=list(BASELINES),
            datasets=list(datasets),
            budgets=budgets,
        )
    report.draw(panels, datasets, figures, judge)
