"""What the coefficients and constants of `fsel` are worth, on training scenes alone."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.capture import Capture
from fsel.evaluation import Evaluator
from fsel.features.conditioned import SHIPPED, Constants
from fsel.files import read_table, write_table, write_text
from fsel.problem import Problem
from fsel.reconstruct import reconstructor_of
from fsel.report.captions import made_by
from fsel.report.latex import MISSING, difference, plain_table, tex
from fsel.report.numbers import write_csv
from fsel.report.summary import differences
from fsel.selector import plain, pretrained
from fsel.selector.policies import POLICIES
from fsel.selector.scorer import Linear
from fsel.split import evaluation_split

logger = logging.getLogger(__name__)

NONE = "shipped"
OTHERS: dict[str, tuple[float, ...]] = {
    **dict.fromkeys(("d_min_s", "gamma_min_s", "phi_nov", "target_gain"), (0.0, 0.5, 2.0)),
    "reach": (0.5, 2.0),
    "turn": (0.0, 0.5, 2.0),
    "fade": (0.5, 0.8, 1.25),
    "novel": (0.5, 2.0),
    "far": (0.5, 2.0, np.inf),
    "few": (0.0, 0.5, 2.0),
    "group": (0.25, 0.5, 2.0),
    "enough": (0.5, 2.0, np.inf),
    "points": (0.0, 0.5, 2.0),
    "angle": (0.5, 2.0),
}
"""Coefficient or constant -> what it is multiplied by."""


def variants() -> Iterator[tuple[str, float, Linear, Constants]]:
    """Name, value, the rule and the constants: as shipped, then with one number changed."""
    shipped = dict(pretrained.method("fsel").scorer.coefficients)
    yield NONE, np.nan, Linear(shipped), SHIPPED
    for name, factors in OTHERS.items():
        for factor in factors:
            if name in shipped:
                value = shipped[name] * factor
                yield name, value, Linear({**shipped, name: value}), SHIPPED
            else:
                value = asdict(SHIPPED)[name] * factor
                yield name, value, Linear(shipped), replace(SHIPPED, **{name: value})


def measure_constants(
    folder: str | Path,
    measured: str | Path,
    *,
    draws: int,
    targets: int,
    budgets: Sequence[int],
    seed: int,
    reconstruction: Mapping,
    config: str,
) -> None:
    """PSNR of a training scene's held-out targets with every variant's picks.

    Args:
        folder: a canonical capture with its descriptors.
        measured: receives name, value, draw, k, psnr.
        draws: of targets.
        targets: of a draw.
        budgets: frames to pick.
        seed: of the draws.
        reconstruction: the config's section.
        config: digest of the parameters.
    """
    capture = Capture.load(folder)
    described = read_table(Path(folder) / "descriptors.parquet")
    reconstructor = reconstructor_of(capture, reconstruction)
    policy, rows = POLICIES["fsel"], []
    for draw in range(draws):
        split = evaluation_split(capture, draw, seed, targets)
        evaluator = Evaluator.on_frames(reconstructor, split.targets, metrics=["psnr"])
        problem = Problem.of(capture, split, described)
        for name, value, rule, constants in variants():
            prepared = policy.prepare(problem, constants)
            picked, _ = plain.greedy(prepared, rule, max(budgets), constants)
            for k in budgets:
                psnr = evaluator(np.sort(prepared.pool[picked[:k]]))[0]
                rows.append({"name": name, "value": value, "draw": draw, "k": k, "psnr": psnr})
        logger.info("draw %d of %d", draw + 1, draws)
    write_table(pd.DataFrame(rows), measured, units={"psnr": "dB"}, config=config)


def fsel_constants(
    measured: Sequence[str | Path],
    table: str | Path,
    numbers: str | Path,
    *,
    scenes: Sequence[str],
    budgets: Sequence[int],
    facts: Mapping,
) -> None:
    """PSNR lost or gained by every other value, on training scenes.

    Args:
        measured: what `measure_constants` wrote, one a scene.
        table: receives LaTeX.
        numbers: receives name, value, shipped, k (`ALL_FRAMES` for the mean of all), mean, ci_low,
            ci_high, p, n.
        scenes: names of the training scenes.
        budgets: columns.
        facts: see `captions.made_by`.
    """
    cells = pd.concat(
        [read_table(p).assign(scene=s) for p, s in zip(measured, scenes, strict=True)]
    )
    found = changes(cells)
    write_csv(found, numbers)
    text = (
        r"\textbf{Coefficients and constants of \texttt{fsel}.} Change of PSNR (dB) when a number "
        "takes another value, the others staying, on the training scenes that refinement practises "
        f"on ({len(scenes)}), held-out targets, and no other scene. Mean over budgets with its "
        "paired 95\\% interval over scenes, bold where it excludes zero. Coefficients (first four) "
        "and constants are explained in \\texttt{docs/methods.md} and "
        f"\\texttt{{fsel.features.conditioned}}. {made_by(facts)}"
    )
    head = ["Number", "shipped", "value", *(f"$K{{=}}{k}$" for k in budgets), "mean"]
    rows = [_row(part, budgets) for _, part in found.groupby(["name", "value"], sort=False)]
    write_text(plain_table(head, rows, caption=text, label="tab:fsel_constants"), table)


def changes(cells: pd.DataFrame) -> pd.DataFrame:
    """name, value, shipped, k (0 for the mean of all), mean, ci_low, ci_high, p, n.

    Args:
        cells: name, value, scene, draw, k, psnr; the shipped numbers have the name `NONE`.
    """
    keys = ["name", "value", "scene", "draw"]
    over = cells.groupby(keys, sort=False, dropna=False)["psnr"].mean().reset_index().assign(k=-1)
    every = pd.concat([cells, over], ignore_index=True)
    shipped = {**pretrained.method("fsel").scorer.coefficients, **asdict(SHIPPED)}
    base, tables = every[every["name"] == NONE].assign(method=NONE), []
    for (name, value), part in every[every["name"] != NONE].groupby(["name", "value"], sort=False):
        pair = pd.concat([part.assign(method="changed"), base]).assign(dataset="training")
        gap = differences(pair, ["changed"], ["psnr"])[["k", "mean", "ci_low", "ci_high", "p", "n"]]
        gap["k"] = gap["k"].clip(lower=0)
        tables.append(gap.assign(name=name, value=value, shipped=shipped[name]))
    order = ["name", "value", "shipped", "k", "mean", "ci_low", "ci_high", "p", "n"]
    return pd.concat(tables)[order].reset_index(drop=True)


def _row(part: pd.DataFrame, budgets: Sequence[int]) -> list[str]:
    gaps = part.set_index("k")[["mean", "ci_low", "ci_high"]]
    name, value, shipped = part[["name", "value", "shipped"]].iloc[0]
    shown = r"$\infty$" if np.isinf(value) else f"{value:g}"
    cells = [
        difference(*gaps.loc[k], interval=False) if k in gaps.index else MISSING for k in budgets
    ]
    return [tex(name), f"{shipped:g}", shown, *cells, difference(*gaps.loc[0])]
