"""Gain of learning over the features: the scorer beside their untrained sum (paper, Table 7)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from fsel.experiments import specs
from fsel.report.captions import made_by
from fsel.report.latex import dataset_table, difference
from fsel.report.numbers import write_csv
from fsel.report.summary import differences
from fsel.report.sweep import named, sweep_cells
from fsel.utils.files import File, Files, write_text
from fsel.workflow.tables import Table

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
    """PSNR of the learned scorer minus that of the untrained sum (paper, Table 7).

    Args:
        table, numbers: receive LaTeX, and dataset, k, mean, ci_low, ci_high, n (scenes).
    """
    cells = sweep_cells(named(problems, evaluations), facts=facts)
    cells = cells[cells["method"].isin([LEARNED, UNTRAINED])]
    gaps = differences(cells, [LEARNED], ["psnr"])
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
        f"{made_by(facts)}"
    )
    counts = gaps.groupby("dataset")["n"].first()
    made = dataset_table(texts, counts, datasets, budgets, caption=text, label="tab:handsign")
    write_text(made, table)


TABLE = Table(
    handsign,
    inputs=specs.sweep_evaluations,
    params=specs.sweep_settings,
    category="Paper",
    title="Learned versus untrained",
    caption="PSNR of the learned scorer minus that of the untrained sum of the same features, with "
    "paired 95% intervals.",
)
