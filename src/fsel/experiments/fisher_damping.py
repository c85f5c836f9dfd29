"""FisherRF's lambda, swept: what its choice is worth."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.baselines.fisher_rf import DAMPING, SWEEP, fisher_rf
from fsel.capture import Capture
from fsel.evaluation import Evaluator
from fsel.files import atomic, read_table, write_table, write_text
from fsel.measuring import PICK_UNITS, chance, measure, measured_units, runs, select
from fsel.problem import Problem
from fsel.reconstruct import reconstructor_of
from fsel.report.latex import number, plain_table
from fsel.split import Split

logger = logging.getLogger(__name__)

DAMPINGS = {f"lambda {damping:g}": damping for damping in SWEEP}


def select_damping(
    folder: str | Path, split: str | Path, picks: str | Path, *, budgets: Sequence[int], config: str
) -> None:
    """FisherRF's picks under every lambda.

    Args:
        folder: a canonical capture with its descriptors.
        split: split.parquet of a draw.
        picks: receives the columns of `fsel.measuring.select`; methods as in `DAMPINGS`.
        budgets: frames to pick.
        config: digest of the parameters.
    """
    methods = [fisher_rf(damping, name, "FisherRF") for name, damping in DAMPINGS.items()]
    problem = Problem.load(folder, split)
    table = select(problem, runs(methods), budgets, chance(0))  # no method here leaves it to chance
    write_table(table, picks, units=PICK_UNITS, config=config)


def evaluate_damping(
    folder: str | Path,
    split: str | Path,
    picks: str | Path,
    evaluation: str | Path,
    *,
    reconstruction: Mapping,
    config: str,
) -> None:
    """What those picks are worth.

    Args:
        folder: a canonical capture.
        split: split.parquet of a draw.
        picks: what `select_damping` wrote.
        evaluation: receives the columns of `fsel.measuring.measure`.
        reconstruction: the config's section.
        config: digest of the parameters.
    """
    reconstructor = reconstructor_of(Capture.load(folder), reconstruction)
    evaluator = Evaluator.on_frames(reconstructor, Split.load(split).targets)
    table = measure(evaluator, read_table(picks))
    logger.info("%s", table.groupby(["method", "k"])["psnr"].mean())
    write_table(table, evaluation, units=measured_units(), config=config)


def fisher_damping(
    evaluations: Sequence[str | Path],
    table: str | Path,
    numbers: str | Path,
    *,
    scenes: Sequence[tuple[str, str]],
    budgets: Sequence[int],
) -> None:
    """PSNR of FisherRF's selections under every lambda.

    Args:
        evaluations: what `evaluate_damping` wrote, one a scene.
        table, numbers: receive LaTeX, and dataset, damping, k, psnr, n (scenes).
        scenes: dataset and scene of each.
        budgets: columns.
    """
    cells = []
    for (dataset, _), path in zip(scenes, evaluations, strict=True):
        psnr = read_table(path).groupby(["method", "k"])["psnr"].mean()
        for name, damping in DAMPINGS.items():
            cells += [(dataset, damping, k, psnr[name, k]) for k in budgets]
    groups = pd.DataFrame(cells, columns=["dataset", "damping", "k", "psnr"])
    groups = groups.groupby(["dataset", "damping", "k"], sort=False)["psnr"]
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
