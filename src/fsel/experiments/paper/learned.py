"""Gain of learning over the features, and spread of its training seeds (paper, Tables 7 and 3)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pandas as pd

from fsel.core.files import File, Files, read_table, write_text
from fsel.evaluation.captions import made_by
from fsel.evaluation.latex import MISSING, dataset_table, difference
from fsel.evaluation.summary import ALL_FRAMES, differences, seed_spread, summarise, write_csv
from fsel.evaluation.sweep import BASELINES, named, sweep_cells

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
    """Write the PSNR of the learned scorer minus that of the untrained sum (paper, Table 7).

    Args:
        table, numbers: receive LaTeX, and dataset, k, mean, ci_low, ci_high, n (scenes).
    """
    cells = sweep_cells(named(problems, evaluations), facts=facts)
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
    """Write the spread of the dataset mean over training seeds, in dB (paper, Table 3).

    Args:
        table, numbers: receive LaTeX, and dataset, k, std, seeds, n (scenes), and margin:
            how far the method's mean is from that of the strongest baseline, which the spread is to
            be read against.
    """
    runs = [_by_seed(item) for item in named(problems, evaluations)]
    spread = seed_spread(pd.concat(runs), "psnr")
    means = summarise(sweep_cells(named(problems, evaluations), facts=facts), ["psnr"])
    spread["margin"] = _margins(means, spread)
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


def _by_seed(item: Mapping) -> pd.DataFrame:
    """Read the learned scorer's rows of one evaluation: dataset, scene, draw, seed, k, psnr."""
    runs = read_table(item["path"]).query("method == @LEARNED")
    means = runs.groupby(["seed", "k"])["psnr"].mean().reset_index()
    return means.assign(dataset=item["dataset"], scene=item["scene"], draw=item["draw"])


def _margins(means: pd.DataFrame, spread: pd.DataFrame) -> list[float]:
    """Return the learned mean minus the strongest baseline's, for every row of `spread`."""
    psnr = means.set_index(["dataset", "k", "method"])["mean"]
    best = means[means["method"].isin(BASELINES) & (means["k"] != ALL_FRAMES)]
    best = best.groupby(["dataset", "k"])["mean"].max()
    return [
        psnr[row.dataset, row.k, LEARNED] - best[row.dataset, row.k] for row in spread.itertuples()
    ]


def _write(
    values: pd.DataFrame,
    texts: Mapping[tuple[str, int], str],
    shown: tuple[Mapping[str, str], Sequence[int]],
    caption: str,
    label: str,
    table: File,
    numbers: File,
) -> None:
    """Write values by dataset and budget; `shown` are both, with the datasets' labels."""
    write_csv(values, numbers)
    counts = values.groupby("dataset")["n"].first()
    write_text(dataset_table(texts, counts, *shown, caption=caption, label=label), table)
