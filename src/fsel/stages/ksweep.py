"""The budget sweep's tables and figure from the evaluations of all scenes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from fsel.baselines import FURTHER, METHODS, PAPER
from fsel.files import atomic, write_text
from fsel.metrics import HIGHER_IS_BETTER, METRICS
from fsel.report import heatmap as heatmaps
from fsel.report.captions import made_by
from fsel.report.latex import sweep_table, tex
from fsel.report.summary import ALL_FRAMES, differences, draw_means, summarise
from fsel.selector.policies import POLICIES

BASELINES = {name: method.label for name, method in {**PAPER, **FURTHER}.items()}
LEARNED = {name: rf"\textbf{{{policy.label}}}" for name, policy in POLICIES.items()}
REFERENCES = {
    "search": r"\textit{Genetic search}",
    "random_search": r"\textit{Random search}",
    "all": METHODS["all"].label,
}
PANELS = ("fsel", "ours")
DECIMALS = 6


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


def sweep_cells(evaluations: Sequence[Mapping]) -> pd.DataFrame:
    """dataset, scene, draw, method, k, metrics: means over targets and seeds of each file."""
    order = {name: i for i, name in enumerate([*BASELINES, *LEARNED, *REFERENCES])}
    tables = []
    for item in evaluations:
        table = draw_means(pd.read_parquet(item["path"]), METRICS)
        tables.append(table.assign(dataset=item["dataset"], scene=item["scene"], draw=item["draw"]))
    cells = pd.concat(tables)
    cells["place"] = cells["method"].map(order)
    datasets = {name: i for i, name in enumerate(cells["dataset"].unique())}
    cells["block"] = cells["dataset"].map(datasets)
    cells = cells.sort_values(["block", "place", "k", "scene", "draw"], kind="stable")
    return cells.drop(columns=["block", "place"]).reset_index(drop=True)


def row_groups(cells: pd.DataFrame, budgets: Sequence[int]) -> list[dict[str, str]]:
    """Method -> label of the rows between two rules, for methods with a number to print."""
    shown = set(cells["method"][cells["k"].isin([*budgets, ALL_FRAMES])])
    labels = {**BASELINES, **LEARNED, **REFERENCES}
    groups = (PAPER, FURTHER, LEARNED, REFERENCES)
    found = [{name: labels[name] for name in group if name in shown} for group in groups]
    return [group for group in found if group]


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


def write_csv(table: pd.DataFrame, path: str | Path) -> None:
    """Six decimals; the budget of a method that takes every frame is written `all`."""
    if "k" in table:
        table = table.assign(k=table["k"].astype(object).where(table["k"] != ALL_FRAMES, "all"))
    with atomic(path) as temporary:
        table.to_csv(temporary, index=False, float_format=f"%.{DECIMALS}f")


def read_csv(path: str | Path) -> pd.DataFrame:
    """What `write_csv` wrote, budgets as numbers again."""
    table = pd.read_csv(path, dtype={"k": str})
    return table.assign(k=table["k"].replace("all", str(ALL_FRAMES)).astype(int))


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
