"""The heatmap of gains over the strongest baseline."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

import pandas as pd

from fsel.core.files import File, Files
from fsel.evaluation import heatmap as report
from fsel.evaluation.summary import read_csv, write_csv
from fsel.evaluation.sweep import BASELINES, with_all_label
from fsel.selectors.baselines import PAPER
from fsel.selectors.policies import POLICIES

PANELS = ("fsel", "less_is_more")
EXTERNAL = [name for name in PAPER if name != "untrained"]  # that is the paper's own control
RIVALS = {"paper": EXTERNAL, "all": list(BASELINES)}
WORDS = {"paper": f"the paper's {len(EXTERNAL)}", "all": f"all {len(BASELINES)}"}


def heatmap(
    numbers: File,
    differences: File,
    figures: Files,
    cells: File,
    *,
    datasets: Mapping[str, str],
    budgets: Sequence[int],
    reconstructor: str = "",
) -> None:
    """Draw the gain of fsel and `less_is_more` over the strongest baseline.

    Args:
        numbers, differences: what `fsel.stages.ksweep` wrote.
        cells: receives its numbers: method, rivals (`paper` or `all` baselines), and the columns of
            `fsel.evaluation.heatmap.gains`.
        reconstructor: its name, where it is not the first; it is named under the figure.
    """
    means, gaps = read_csv(numbers), read_csv(differences)
    panels, rows = {}, []
    labels = with_all_label(datasets)
    for method, (rivals, baselines) in product(PANELS, RIVALS.items()):
        title = f"{POLICIES[method].label}, over the strongest of {WORDS[rivals]}"
        panel = report.gains(
            means, gaps, method=method, baselines=baselines, datasets=list(labels), budgets=budgets
        )
        panels[title] = panel
        rows.append(panel.assign(method=method, rivals=rivals))
    write_csv(pd.concat(rows), cells)
    report.draw(panels, labels, figures, reconstructor)
