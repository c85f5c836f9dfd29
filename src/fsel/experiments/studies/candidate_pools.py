"""`less_is_more` and the baselines with equal freedom: what they may pick, and what they know."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import pandas as pd

from fsel.baselines import METHODS, PAPER
from fsel.data.capture import Capture
from fsel.data.problem import Problem
from fsel.data.split import Split
from fsel.evaluation import measuring
from fsel.evaluation.evaluator import Evaluator
from fsel.evaluation.measuring import Run
from fsel.reconstruct import reconstructor_of
from fsel.report.captions import made_by
from fsel.report.latex import difference, number, plain_table
from fsel.report.numbers import write_csv
from fsel.report.summary import differences, draw_means, summarise
from fsel.report.sweep import BASELINES, LEARNED, place_of
from fsel.selector.policies import POLICIES
from fsel.utils.files import read_table, write_table, write_text

OURS = POLICIES["less_is_more"]
FREEDOMS = {
    "candidates": "from P, targets known by proxies",
    "observed": "from P and O, targets known by proxies",
    "targets": "from P and O, target poses known",
}
POLICY = {
    "candidates": OURS,
    "observed": replace(OURS, pool="observed"),
    "targets": replace(OURS, pool="observed", reference="targets"),
}
"""The paper's policy with the freedom of its baselines, and with that of `fsel`."""
BY = ["draw", "freedom", *measuring.SELECTION]


def select_freedom(
    folder: str | Path,
    splits: Sequence[str | Path],
    weights: Sequence[str | Path],
    rules: Sequence[str | Path],
    picks: str | Path,
    *,
    budgets: Sequence[int],
    seeds: Sequence[int],
    config: str,
) -> None:
    """Picks of ours and the paper's baselines from P, and from P and O; and with target poses.

    Only Nearest and `fsel` look at target poses: they stand beside ours where it does.

    Args:
        folder: a canonical capture with its descriptors.
        splits: split.parquet, one a draw.
        weights: scorers of `less_is_more`, one a training seed; nothing is trained anew.
        rules: scorers of `fsel`.
        picks: receives draw, freedom and the columns of `fsel.evaluation.measuring.select`.
        budgets: frames to pick.
        seeds: one a draw.
        config: digest of the parameters.
    """
    learned = measuring.learned_runs(weights)
    others = {
        "candidates": measuring.runs(PAPER.values()),
        "observed": measuring.runs(PAPER.values()),
        "targets": measuring.runs([METHODS["nearest"]], rules),
    }
    tables = []
    for draw, (split, seed) in enumerate(zip(splits, seeds, strict=True)):
        known = Problem.load(folder, split)
        for freedom, policy in POLICY.items():
            problem = replace(known, proxies_free=freedom != "candidates")
            ours = [Run(policy.method(run.method.scorer), run.seed) for run in learned]
            asked = [*others[freedom], *ours]
            found = measuring.select(problem, asked, budgets, measuring.chance(seed))
            tables.append(found.assign(draw=draw, freedom=freedom))
    write_table(pd.concat(tables), picks, units=measuring.PICK_UNITS, config=config)


def evaluate_freedom(
    folder: str | Path,
    splits: Sequence[str | Path],
    picks: str | Path,
    evaluation: str | Path,
    *,
    reconstruction: Mapping,
    config: str,
) -> None:
    """What those picks are worth; equal picks are reconstructed once.

    Args:
        folder: a canonical capture.
        splits: split.parquet, one a draw.
        picks: what `select_freedom` wrote.
        evaluation: receives draw, freedom and the columns of `fsel.evaluation.measuring.measure`.
        reconstruction: the config's section.
        config: digest of the parameters.
    """
    reconstructor = reconstructor_of(Capture.load(folder), reconstruction)
    tables = []
    for draw, part in read_table(picks).groupby("draw"):
        targets = Split.load(splits[int(draw)]).targets
        tables.append(measuring.measure(Evaluator.on_frames(reconstructor, targets), part, BY))
    write_table(pd.concat(tables), evaluation, units=measuring.measured_units(), config=config)


def freedom(
    evaluations: Sequence[str | Path],
    table: str | Path,
    numbers: str | Path,
    *,
    scenes: Sequence[tuple[str, str]],
    budgets: Sequence[int],
    facts: Mapping,
) -> None:
    """Mean PSNR over all evaluation scenes, a block of rows a freedom.

    Args:
        evaluations: what `evaluate_freedom` wrote, one a scene.
        table: receives LaTeX.
        numbers: receives freedom, method, reference (of a difference of ours to it; empty for a
            mean), k, mean, ci_low, ci_high, n.
        scenes: dataset and scene of each file.
        budgets: columns.
        facts: see `captions.made_by`.
    """
    cells = _cells(scenes, evaluations, facts)
    means = summarise(cells, ["psnr"]).assign(reference="")
    gaps = differences(cells, [OURS.name], ["psnr"])
    both = pd.concat([means, gaps]).rename(columns={"dataset": "freedom"})
    order = ["freedom", "method", "reference", "k", "mean", "ci_low", "ci_high", "n"]
    write_csv(both[order], numbers)
    text = (
        r"\textbf{Equal freedom.} PSNR (dB) of the same weights of ours and of baselines, where "
        "all may pick the same frames and know the same of the targets; the paper compares the "
        "first row of ours with the baselines of the second block. In brackets beside ours: its "
        "paired difference to the strongest other row of the block, with a 95\\% interval over "
        f"{means['n'].max()} scenes; bold where that excludes zero. {made_by(facts)}"
    )
    rows = [row for freedom in FREEDOMS for row in _block(means, gaps, freedom, budgets)]
    head = ["Selection", *(f"$K{{=}}{k}$" for k in budgets)]
    write_text(plain_table(head, rows, caption=text, label="tab:freedom"), table)


def _cells(
    scenes: Sequence[tuple[str, str]], evaluations: Sequence[str | Path], facts: Mapping
) -> pd.DataFrame:
    """dataset (the freedom), scene, place, draw, method, k, psnr: means over targets and seeds."""
    tables = []
    for scene, path in zip(map("/".join, scenes), evaluations, strict=True):
        place = place_of(scene, facts)
        for (draw, kind), part in read_table(path).groupby(["draw", "freedom"]):
            where = {"dataset": kind, "scene": scene, "place": place, "draw": draw}
            tables.append(draw_means(part, ["psnr"]).assign(**where))
    return pd.concat(tables, ignore_index=True)


def _block(
    means: pd.DataFrame, gaps: pd.DataFrame, freedom: str, budgets: Sequence[int]
) -> list[list[str]]:
    """A heading, the baselines, and ours with its distance to the strongest of them."""
    part = means[means["dataset"] == freedom].set_index(["method", "k"])["mean"]
    less = gaps[gaps["dataset"] == freedom].set_index(["reference", "k"])
    labels = {name: label for name, label in {**BASELINES, **LEARNED}.items() if name in part}
    others = [name for name in labels if name != OURS.name]
    rows = [[rf"\textit{{{FREEDOMS[freedom]}}}", *[""] * len(budgets)]]
    for name in others:
        rows.append([labels[name], *(number(part[name, k], "psnr") for k in budgets)])
    own = []
    for k in budgets:
        strongest = max(others, key=lambda name: part[name, k])
        gap = less.loc[(strongest, k), ["mean", "ci_low", "ci_high"]]
        own.append(f"{number(part[OURS.name, k], 'psnr')} ({difference(*gap)})")
    return [*rows, [labels[OURS.name], *own]]
