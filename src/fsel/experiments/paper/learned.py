"""Gain of learning over the features, and spread of its training seeds (paper, Tables 7 and 3)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pandas as pd

from fsel.core.files import File, Files, write_text
from fsel.evaluation.latex import MISSING, difference, made_by, plain_table, tex
from fsel.evaluation.summary import ALL_FRAMES, differences, seed_spread, summarise, write_csv
from fsel.evaluation.sweep import BASELINES, sweep_cells

LEARNED, UNTRAINED = "less_is_more", "untrained"


def handsign(
    evaluations: Files,
    table: File,
    numbers: File,
    *,
    problems: Sequence[str],
    datasets: Mapping[str, str],
    budgets: Sequence[int],
    facts: Mapping,
) -> None:
    """Write the PSNR of the learned scorer minus that of the untrained sum (paper, Table 7)."""
    cells = sweep_cells(problems, evaluations, facts=facts)
    cells = cells[cells["method"].isin([LEARNED, UNTRAINED])]
    gaps = differences(cells, [LEARNED], ["psnr"])
    values = gaps.set_index(["dataset", "k"])[["mean", "ci_low", "ci_high"]]
    texts = {
        cell: difference(*bounds)
        for cell, bounds in zip(values.index, values.to_numpy(), strict=True)
    }
    ahead, count = int((gaps["mean"] > 0).sum()), len(gaps)
    text = (
        r"\textbf{Learned versus untrained feature aggregation.} PSNR difference (dB) between "
        "the learned selector and a control that sums the same features, sign-corrected and "
        "standardised, in the same greedy loop with nothing fitted. Positive values favour the "
        f"learned scorer, which is ahead in ${ahead}$ of the ${count}$ cells; their mean is "
        f"${gaps['mean'].mean():+.2f}$\\,dB. In brackets: paired 95\\% intervals over "
        "scenes and draws; bold where they exclude zero. $n$: evaluation scenes. "
        f"{made_by(facts)}"
    )
    _write(gaps, texts, (datasets, budgets), text, "tab:handsign", table, numbers)


def seedvar(
    evaluations: Files,
    table: File,
    numbers: File,
    *,
    problems: Sequence[str],
    datasets: Mapping[str, str],
    budgets: Sequence[int],
    facts: Mapping,
) -> None:
    """Write the spread of the dataset mean over training seeds, in dB (paper, Table 3), and beside
    it in `numbers` the margin over the strongest baseline."""
    runs = sweep_cells(problems, evaluations, facts=facts, by_seed=True)
    spread = seed_spread(runs[runs["method"] == LEARNED], "psnr")
    means = summarise(sweep_cells(problems, evaluations, facts=facts), ["psnr"])
    psnr = means.set_index(["dataset", "k", "method"])["mean"]
    best = means[means["method"].isin(BASELINES) & (means["k"] != ALL_FRAMES)]
    best = best.groupby(["dataset", "k"])["mean"].max()
    spread["margin"] = [
        psnr[row.dataset, row.k, LEARNED] - best[row.dataset, row.k] for row in spread.itertuples()
    ]
    texts = {
        (row.dataset, row.k): MISSING if pd.isna(row.std) else f"{row.std:.3f}"
        for row in spread.itertuples()
    }
    inside = int((spread["std"] < spread["margin"].abs()).sum())
    text = (
        r"\textbf{Seed variability.} Standard deviation (dB) of the dataset-mean PSNR across "
        f"training seeds (${spread['seeds'].max()}$), which differ only in initialization and in "
        "the order training items are presented. It is smaller than the distance to the strongest "
        f"baseline, whichever is ahead, in ${inside}$ of ${len(spread)}$ cells. $n$: evaluation "
        f"scenes. {made_by(facts)}"
    )
    _write(spread, texts, (datasets, budgets), text, "tab:seedvar", table, numbers)


def _write(
    values: pd.DataFrame,
    texts: Mapping[tuple[str, int], str],
    shown: tuple[Mapping[str, str], Sequence[int]],
    caption: str,
    label: str,
    table: File,
    numbers: File,
) -> None:
    """Write values, a row a dataset and a column a budget; `shown` are both, with labels."""
    write_csv(values, numbers)
    (datasets, budgets), counts = shown, values.groupby("dataset")["n"].first()
    rows = [
        [tex(title), str(counts[name]), *(texts[name, k] for k in budgets)]
        for name, title in datasets.items()
    ]
    head = ["Dataset", "$n$", *(f"$K{{=}}{k}$" for k in budgets)]
    write_text(plain_table(head, rows, caption=caption, label=label), table)
