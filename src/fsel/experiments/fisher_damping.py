"""FisherRF's lambda, swept: what its choice is worth."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.baselines.fisher_rf import DAMPING, SWEEP, fisher_rf
from fsel.evaluation import Evaluator
from fsel.files import atomic, write_text
from fsel.problem import Problem, checked_select
from fsel.reconstruct import reconstructor_of
from fsel.report.latex import number, plain_table
from fsel.split import Split

logger = logging.getLogger(__name__)


def fisher_damping(
    problems: Sequence[Mapping],
    table: str | Path,
    numbers: str | Path,
    *,
    budgets: Sequence[int],
    reconstruction: Mapping,
) -> None:
    """PSNR of FisherRF's selections under every lambda.

    Args:
        problems: one mapping a problem: dataset, folder (a canonical capture with its descriptors)
            and split.
        table, numbers: receive LaTeX, and dataset, damping, k, psnr, n (problems).
        budgets: frames to pick.
        reconstruction: the config's section.
    """
    rows = []
    for item in problems:
        problem = Problem.load(item["folder"], item["split"])
        targets = Split.load(item["split"]).targets
        evaluate = Evaluator.on_frames(reconstructor_of(problem.capture, reconstruction), targets)
        for damping in SWEEP:
            method = fisher_rf(damping, "fisher_rf", "FisherRF")
            picks = checked_select(method, problem, max(budgets), np.random.default_rng(0))
            rows += [(item["dataset"], damping, k, evaluate(picks[:k])[0]) for k in budgets]
        logger.info("%s: %d selections", item["folder"], len(SWEEP) * len(budgets))
    cells = pd.DataFrame(rows, columns=["dataset", "damping", "k", "psnr"])
    groups = cells.groupby(["dataset", "damping", "k"], sort=False)["psnr"]
    means = groups.agg(psnr="mean", n="size").reset_index()
    with atomic(numbers) as temporary:
        means.to_csv(temporary, index=False, float_format="%.6f")
    write_text(_table(means, budgets), table)


def _table(means: pd.DataFrame, budgets: Sequence[int]) -> str:
    wide = means.groupby(["damping", "k"])["psnr"].mean().unstack()
    rows = [
        [_power(damping), *(number(wide.loc[damping, k], "psnr") for k in budgets)]
        for damping in SWEEP
    ]
    return plain_table(
        [r"$\lambda$", *(f"$K{{=}}{k}$" for k in budgets)],
        rows,
        caption=r"\textbf{FisherRF's $\lambda$}. PSNR$\uparrow$ in dB, means over scenes, then "
        f"datasets; the comparison uses {_power(DAMPING)}, the released default.",
        label="tab:fisher_damping",
    )


def _power(value: float) -> str:
    """A power of ten as such, in LaTeX."""
    exponent = round(np.log10(value))
    return f"$10^{{{exponent}}}$" if np.isclose(value, 10.0**exponent) else f"${value:g}$"
