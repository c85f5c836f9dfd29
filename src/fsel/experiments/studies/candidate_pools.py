"""`less_is_more` and the baselines with equal candidate pools and knowledge of the targets."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import cast

import pandas as pd

from fsel.core.capture import Capture
from fsel.core.files import File, Files, write_text
from fsel.core.problem import Problem
from fsel.core.split import Split
from fsel.evaluation.latex import difference, made_by, number, plain_table
from fsel.evaluation.measuring import Run, rng_by_name, runs
from fsel.evaluation.summary import differences, summarise, write_csv
from fsel.evaluation.sweep import LABELS
from fsel.experiments.scheme import ExperimentCase, Scenes, Trials, cells_of
from fsel.selectors.baselines import METHODS, PAPER
from fsel.selectors.policies import POLICIES, ScoringMethod

OURS = POLICIES["less_is_more"]
SETTINGS = {
    "candidates": "from P, targets known by proxies",
    "observed": "from P and O, targets known by proxies",
    "targets": "from P and O, target poses known",
}
POLICY = {
    "candidates": OURS,
    "observed": replace(OURS, pool="observed"),
    "targets": replace(OURS, pool="observed", reference="targets"),
}
"""The paper's policy with the pool of its baselines, and with that of `fsel`."""


def trials(
    capture: Capture, splits: Sequence[Split], *, budgets: Sequence[int], seeds: Sequence[int]
) -> Iterator[ExperimentCase]:
    """Yield every draw under every setting: from P, from P and O, and with target poses."""
    for draw, (split, seed) in enumerate(zip(splits, seeds, strict=True)):
        for setting in SETTINGS:
            yield ExperimentCase(
                {"draw": draw, "setting": setting},
                capture,
                split,
                budgets,
                rng_by_name(seed),
                problem=partial(_pooled, setting),
                entered=partial(_entered, setting),
            )


def _pooled(setting: str, capture: Capture, split: Split, described: pd.DataFrame) -> Problem:
    problem = Problem.of(capture, split, described)
    return replace(problem, proxies_free=setting != "candidates")


def _entered(setting: str, learned: list[Run]) -> list[Run]:
    """Ours with the policy of a setting, beside the baselines that know as much of the targets."""
    ours = [run for run in learned if run.method.name == OURS.name]
    others = runs(PAPER.values())
    if setting == "targets":
        others = runs([METHODS["nearest"]]) + [run for run in learned if run not in ours]
    scorers = [cast(ScoringMethod, run.method).scorer for run in ours]
    return others + [Run(POLICY[setting].method(scorer), n) for n, scorer in enumerate(scorers)]


def candidate_pools(
    evaluations: Files,
    table: File,
    numbers: File,
    *,
    scenes: Scenes,
    budgets: Sequence[int],
    facts: Mapping,
) -> None:
    """Write the mean PSNR over all evaluation scenes, a block of rows a setting.

    In `numbers`, `reference` names what a difference of ours is to, and is empty for a mean.
    """
    cells = cells_of(scenes, evaluations, ["psnr"], facts, ["draw", "setting"])
    cells = cells.assign(dataset=cells["setting"])
    means = summarise(cells, ["psnr"]).assign(reference="")
    gaps = differences(cells, [OURS.name], ["psnr"])
    both = pd.concat([means, gaps]).rename(columns={"dataset": "setting"})
    order = ["setting", "method", "reference", "k", "mean", "ci_low", "ci_high", "n"]
    write_csv(both[order], numbers)
    text = (
        r"\textbf{Equal candidate pools.} PSNR (dB) of the same weights of ours and of "
        "baselines, where all may pick the same frames and know the same of the targets; the paper "
        "compares the first row of ours with the baselines of the second block. In brackets beside "
        "ours: its paired difference to the strongest other row of the block, with a 95\\% "
        f"interval over {means['n'].max()} scenes; bold where that excludes zero. {made_by(facts)}"
    )
    rows = [row for setting in SETTINGS for row in _block(means, gaps, setting, budgets)]
    head = ["Selection", *(f"$K{{=}}{k}$" for k in budgets)]
    write_text(plain_table(head, rows, caption=text, label="tab:candidate_pools"), table)


def _block(
    means: pd.DataFrame, gaps: pd.DataFrame, setting: str, budgets: Sequence[int]
) -> list[list[str]]:
    """A heading, the baselines, and ours with its distance to the strongest of them."""
    part = means[means["dataset"] == setting].set_index(["method", "k"])["mean"]
    less = gaps[gaps["dataset"] == setting].set_index(["reference", "k"])
    labels = {name: label for name, label in LABELS.items() if name in part}
    others = [name for name in labels if name != OURS.name]
    rows = [[rf"\textit{{{SETTINGS[setting]}}}", *[""] * len(budgets)]]
    for name in others:
        rows.append([labels[name], *(number(part[name, k], "psnr") for k in budgets)])
    own = []
    for k in budgets:
        strongest = max(others, key=lambda name: part[name, k])
        gap = less.loc[(strongest, k), ["mean", "ci_low", "ci_high"]]
        own.append(f"{number(part[OURS.name, k], 'psnr')} ({difference(*gap)})")
    return [*rows, [labels[OURS.name], *own]]


TRIALS = Trials(trials)
