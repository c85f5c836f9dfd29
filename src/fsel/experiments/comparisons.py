"""What learning adds to the features, and how far training seeds spread."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from fsel.files import write_text
from fsel.report.captions import made_by
from fsel.report.latex import MISSING, difference, plain_table, tex
from fsel.report.summary import ALL_FRAMES, differences, seed_spread, summarise
from fsel.stages.ksweep import BASELINES, Sweep, sweep_cells, write_csv

LEARNED, UNTRAINED = "ours", "untrained"


def handsign(sweep: Sweep, table: str | Path, numbers: str | Path) -> None:
    """PSNR of the learned scorer minus that of the untrained sum (paper, Table 7).

    Args:
        sweep: see `tables.Sweep`.
        table, numbers: receive LaTeX, and dataset, k, mean, ci_low, ci_high, n (scenes).
    """
    cells = sweep_cells(sweep.evaluations)
    cells = cells[cells["method"].isin([LEARNED, UNTRAINED])]
    gaps = differences(cells, [LEARNED], ["psnr"], **sweep.bootstrap)
    write_csv(gaps, numbers)
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
        f"{made_by(sweep.facts)}"
    )
    counts = gaps.groupby("dataset")["n"].first()
    rows = _rows(texts, counts, sweep)
    write_text(plain_table(_head(sweep.budgets), rows, caption=text, label="tab:handsign"), table)


def seedvar(sweep: Sweep, table: str | Path, numbers: str | Path) -> None:
    """Spread of the dataset mean over training seeds (paper, Table 3); arguments as `handsign`.

    The numbers are dataset, k, std, seeds, n, and margin: how far the method's mean is from that
    of the strongest baseline, which the spread is to be read against.
    """
    runs = [_by_seed(item) for item in sweep.evaluations]
    spread = seed_spread(pd.concat(runs), "psnr")
    means = summarise(sweep_cells(sweep.evaluations), ["psnr"], **sweep.bootstrap)
    spread["margin"] = _margins(means, spread)
    write_csv(spread, numbers)
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
        f"scenes. {made_by(sweep.facts)}"
    )
    counts = spread.groupby("dataset")["n"].first()
    rows = _rows(texts, counts, sweep)
    write_text(plain_table(_head(sweep.budgets), rows, caption=text, label="tab:seedvar"), table)


def _by_seed(item: Mapping) -> pd.DataFrame:
    """The learned scorer's rows of one evaluation: dataset, scene, draw, seed, k, psnr."""
    runs = pd.read_parquet(item["path"]).query("method == @LEARNED")
    means = runs.groupby(["seed", "k"])["psnr"].mean().reset_index()
    return means.assign(dataset=item["dataset"], scene=item["scene"], draw=item["draw"])


def _margins(means: pd.DataFrame, spread: pd.DataFrame) -> list[float]:
    """The learned scorer's mean minus the strongest baseline's, for every row of `spread`."""
    psnr = means.set_index(["dataset", "k", "method"])["mean"]
    best = means[means["method"].isin(BASELINES) & (means["k"] != ALL_FRAMES)]
    best = best.groupby(["dataset", "k"])["mean"].max()
    return [
        psnr[row.dataset, row.k, LEARNED] - best[row.dataset, row.k] for row in spread.itertuples()
    ]


def _head(budgets: Sequence[int]) -> list[str]:
    return ["Dataset", "$n$", *(f"$K{{=}}{k}$" for k in budgets)]


def _rows(
    texts: Mapping[tuple[str, int], str], counts: Mapping[str, int], sweep: Sweep
) -> list[list[str]]:
    return [
        [tex(label), str(counts[name]), *(texts[name, k] for k in sweep.budgets)]
        for name, label in sweep.datasets.items()
    ]


TABLES = {"handsign": handsign, "seedvar": seedvar}
