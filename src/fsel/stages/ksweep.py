"""The budget sweep's tables and figure from the evaluations of all scenes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from fsel.files import write_text
from fsel.metrics import HIGHER_IS_BETTER, METRICS
from fsel.report import heatmap as heatmaps
from fsel.report.captions import made_by
from fsel.report.latex import sweep_table, tex
from fsel.report.numbers import read_csv, write_csv
from fsel.report.summary import differences, summarise
from fsel.report.sweep import BASELINES, LEARNED, row_groups, sweep_cells
from fsel.selector.policies import POLICIES

PANELS = ("fsel", "ours")


@dataclass(frozen=True)
class Sweep:
    """What tables of the budget sweep are made of.

    Attributes:
        evaluations: one mapping a file: dataset, scene, draw, path.
        datasets: name -> printed label, in order.
        budgets: columns.
        bootstrap: its `resamples` and `seed`.
        facts: what the caption tells, see `caption`.
    """

    evaluations: Sequence[Mapping]
    datasets: Mapping[str, str]
    budgets: Sequence[int]
    bootstrap: Mapping[str, int]
    facts: Mapping


def ksweep(sweep: Sweep, table: str | Path, summary: str | Path, paired: str | Path) -> None:
    """The table "Input budget sweep", its numbers with intervals, and paired differences.

    Args:
        sweep: see `Sweep`.
        table: receives the LaTeX table.
        summary, paired: receive means, and the learned methods' differences to every other.
    """
    cells = sweep_cells(sweep.evaluations)
    means = summarise(cells, METRICS, **sweep.bootstrap)
    gaps = differences(cells, list(LEARNED), METRICS, **sweep.bootstrap)
    write_csv(means, summary)
    write_csv(gaps, paired)
    groups = row_groups(cells, sweep.budgets)
    searched = any("search" in group for group in groups)
    text = sweep_table(
        means,
        datasets={name: tex(label) for name, label in sweep.datasets.items()},
        groups=groups,
        ranked=[*BASELINES, *LEARNED],
        budgets=sweep.budgets,
        higher_is_better=HIGHER_IS_BETTER,
        caption=caption({**sweep.facts, "searched": searched}),
        label="tab:ksweep_all",
    )
    write_text(text, table)


def caption(facts: Mapping) -> str:
    """Which captures, reconstructor, descriptor and metric made the table, in LaTeX.

    Args:
        facts: embedded (labels of datasets of generated captures), real (labels of datasets read
            from disk), reconstructor, long_side, descriptor, search_k, draws, oracle_draws,
            searched (whether the searches have rows).
    """
    references = "all frames without selection."
    if facts["searched"]:
        references = (
            "searches, which reconstruct hundreds of subsets of every scene "
            rf"($K{{=}}{facts['search_k']}$, {facts['oracle_draws']} of {facts['draws']} target "
            f"draws), and {references}"
        )
    return (
        r"\textbf{Input budget sweep across datasets}. Each cell reports "
        rf"PSNR$\uparrow$~/~SSIM$\uparrow$~/~{METRICS[-1].upper()}$\downarrow$, averaged over "
        "targets, target draws and seeds within a scene, then over scenes; the best selection of "
        f"each column is in bold. {made_by(facts)} Between rules: the paper's "
        f"baselines, further ones, the learned selectors, and for reference {references}"
    )


def heatmap(
    summary: str | Path,
    paired: str | Path,
    outputs: Sequence[str | Path],
    *,
    datasets: Mapping[str, str],
    budgets: Sequence[int],
) -> None:
    """Gain of fsel and of ours over the strongest baseline, from the sweep's numbers."""
    means, gaps = read_csv(summary), read_csv(paired)
    panels = {}
    for method in PANELS:
        title = f"{POLICIES[method].label}: gain over the strongest baseline"
        panels[title] = heatmaps.gains(
            means,
            gaps,
            method=method,
            baselines=list(BASELINES),
            datasets=list(datasets),
            budgets=budgets,
        )
    heatmaps.draw(panels, datasets, outputs)
