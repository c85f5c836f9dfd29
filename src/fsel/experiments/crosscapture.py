"""Targets from one pass of a room, frames from its other passes (paper, Table 1)."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.optimize import linear_sum_assignment

from fsel.baselines import METHODS
from fsel.capture import Capture
from fsel.evaluation import Evaluator
from fsel.files import write_table, write_text
from fsel.geometry import pose_distance
from fsel.measuring import PICK_UNITS, Chance, Run, measure, measured_units, runs, select
from fsel.metrics import Metrics, headings
from fsel.problem import Problem
from fsel.reconstruct import reconstructor_of
from fsel.report.captions import made_by
from fsel.report.latex import number, plain_table
from fsel.report.numbers import write_csv
from fsel.report.summary import differences, draw_means, leaders, summarise
from fsel.report.sweep import LEARNED, of_scenes
from fsel.seeds import name_seed
from fsel.split import Split

logger = logging.getLogger(__name__)

BASELINES = ("random", "uniform", "fvs", "nerf_director", "dpp", "kmedoids", "cover")
SHOWN = {**{name: METHODS[name].label for name in BASELINES}, **LEARNED}


def cross_split(capture: Capture, held_out: str) -> Split:
    """Targets from a held-out pass, proxies and candidates from the others.

    Targets are the half of the held-out pass that is nearest to a frame of another pass; its other
    half is not used. Each target takes one distinct proxy, minimising the summed distance.

    Args:
        capture: of several passes.
        held_out: the pass, one of `capture.sequences`.

    Raises:
        ValueError: when the other passes have fewer frames than there are targets.
    """
    inside = np.array(capture.sequences) == held_out
    away, rest = np.flatnonzero(inside), np.flatnonzero(~inside)
    count = max(1, len(away) // 2)
    if len(rest) <= count:
        raise ValueError(
            f"{capture.source}: {len(rest)} frames outside {held_out!r} for {count} targets in it. "
            "Hint: a cross-capture scene needs two or more passes"
        )
    centers, axes = capture.centers, capture.axes
    cost = pose_distance(centers[away], axes[away], centers[rest], axes[rest])
    near = np.sort(np.argsort(cost.min(axis=1), kind="stable")[:count])
    _, match = linear_sum_assignment(cost[near])
    candidates = np.setdiff1d(rest, rest[match])
    return Split(away[near], rest[match], candidates, candidates)


def select_crosscapture(
    folder: str | Path,
    weights: Sequence[str | Path],
    picks: str | Path,
    *,
    budgets: Sequence[int],
    seed: int,
    config: str,
) -> None:
    """Every method's picks with every pass of a room held out in turn.

    Args:
        folder: a canonical capture of several passes, with its descriptors.
        weights: scorers of the learned methods.
        picks: receives held_out and the columns of `fsel.measuring.select`.
        budgets: frames to pick.
        seed: of the scene.
        config: digest of the parameters.
    """
    capture = Capture.load(folder)
    described = pd.read_parquet(Path(folder) / "descriptors.parquet")
    asked = runs([METHODS[name] for name in BASELINES], weights)
    tables = []
    for held_out in dict.fromkeys(capture.sequences):
        problem = Problem.of(capture, cross_split(capture, held_out), described)
        found = select(problem, asked, budgets, _chance(seed, held_out))
        tables.append(found.assign(held_out=held_out))
        logger.info("%s: %d targets held out", held_out, len(problem.targets))
    write_table(pd.concat(tables), picks, units=PICK_UNITS, config=config)


def _chance(seed: int, held_out: str) -> Chance:
    def of(run: Run, k: int) -> np.random.Generator:
        return np.random.default_rng([seed, run.seed, name_seed(held_out), k])

    return of


def evaluate_crosscapture(
    folder: str | Path,
    picks: str | Path,
    evaluation: str | Path,
    *,
    reconstruction: Mapping,
    metrics: Metrics,
    config: str,
) -> None:
    """What the picks are worth on the targets of the pass that was held out.

    Args:
        folder: a canonical capture of several passes.
        picks: what `select_crosscapture` wrote.
        evaluation: receives held_out and the columns of `fsel.measuring.measure`.
        reconstruction: the config's section.
        metrics: names, or name -> settings.
        config: digest of the parameters.
    """
    reconstructor = reconstructor_of(Capture.load(folder), reconstruction)
    tables = []
    for held_out, part in pd.read_parquet(picks).groupby("held_out"):
        targets = cross_split(reconstructor.capture, held_out).targets
        table = measure(Evaluator.on_frames(reconstructor, targets, metrics=metrics), part)
        tables.append(table.assign(held_out=held_out))
        logger.info("%s: %.2f dB", held_out, table["psnr"].mean())
    write_table(pd.concat(tables), evaluation, units=measured_units(metrics), config=config)


def crosscapture(
    evaluations: Sequence[str | Path],
    table: str | Path,
    numbers: str | Path,
    *,
    scenes: Sequence[tuple[str, str]],
    budgets: Sequence[int],
    metrics: Metrics,
    facts: Mapping,
) -> None:
    """The table "Cross-capture novel view synthesis"; one measurement a room and held-out pass.

    Args:
        evaluations: what `evaluate_crosscapture` wrote, one a room.
        table, numbers: receive LaTeX, and method, k, metric, mean, ci_low, ci_high, leads, n.
        scenes: dataset and scene of every room.
        budgets: columns.
        metrics: of a cell, in order; names, or name -> settings.
        facts: see `captions.made_by`.
    """
    cells = pd.concat(
        [part for item in of_scenes(scenes, evaluations) for part in _measurements(item, metrics)]
    )
    means = summarise(cells, metrics).drop(columns="dataset")
    ahead = leaders(differences(cells, list(SHOWN), metrics))
    keys = zip(means["method"], means["k"], means["metric"], strict=True)
    means["leads"] = [key in ahead for key in keys]
    write_csv(means, numbers)
    text = (
        r"\textbf{Cross-capture novel view synthesis.} Targets are the nearest half of one "
        "held-out pass of a room; candidates and proxies come from its other passes. Means over "
        f"{means['n'].max()} pairs of room and held-out pass. Bold: ahead of every other row, each "
        f"paired 95\\% interval over them excluding zero. {made_by(facts)}"
    )
    head = ["Method", *headings(metrics) * len(budgets)]
    values = means.set_index(["method", "k", "metric"])
    rows = [
        [label, *(_cell(values, name, k, metric) for k in budgets for metric in metrics)]
        for name, label in SHOWN.items()
    ]
    groups = [(f"$K{{=}}{k}$", len(metrics)) for k in budgets]
    made = plain_table(head, rows, caption=text, label="tab:crossvideowopt", groups=groups)
    write_text(made, table)


def _measurements(item: Mapping, metrics: Metrics) -> Iterator[pd.DataFrame]:
    """dataset, scene (room and pass), draw, method, k, metrics of every held-out pass."""
    for held_out, part in pd.read_parquet(item["path"]).groupby("held_out"):
        scene = f"{item['dataset']}/{item['scene']}/{held_out}"
        # one set of measurements whatever the dataset, so that each counts once
        yield draw_means(part, metrics).assign(dataset="crosscapture", scene=scene, draw=0)


def _cell(values: pd.DataFrame, method: str, k: int, metric: str) -> str:
    row = values.loc[(method, k, metric)]
    text = number(row["mean"], metric)
    return rf"\textbf{{{text}}}" if row["leads"] else text
