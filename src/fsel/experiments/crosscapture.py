"""Targets from one pass of a room, frames from its other passes (paper, Table 1)."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.optimize import linear_sum_assignment

from fsel.baselines import METHODS
from fsel.capture import Capture
from fsel.evaluation import Evaluator
from fsel.files import write_table, write_text
from fsel.geometry import pose_distance
from fsel.metrics import HIGHER_IS_BETTER, METRIC_UNITS, METRICS
from fsel.problem import Method, Problem, checked_select
from fsel.reconstruct import reconstructor_of
from fsel.report.captions import made_by
from fsel.report.latex import number, plain_table
from fsel.report.numbers import write_csv
from fsel.report.summary import differences, draw_means, summarise
from fsel.report.sweep import LEARNED
from fsel.seeds import name_seed
from fsel.selector.policies import POLICIES
from fsel.selector.scorer import Scorer
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


def measure_crosscapture(
    folder: str | Path,
    weights: Mapping[str, Sequence[str | Path]],
    output: str | Path,
    *,
    budgets: Sequence[int],
    seed: int,
    reconstruction: Mapping,
    config: str,
) -> None:
    """Every method with every pass of a room held out in turn.

    Args:
        folder: a canonical capture of several passes, with its descriptors.
        weights: learned method -> its scorers, one a training seed.
        output: receives held_out, method, seed, k, target, metrics.
        budgets: frames to pick.
        seed: of the scene.
        reconstruction: the config's section.
        config: digest of the parameters.
    """
    capture = Capture.load(folder)
    described = pd.read_parquet(Path(folder) / "descriptors.parquet")
    reconstructor = reconstructor_of(capture, reconstruction)
    runs = contenders(BASELINES, weights)
    tables = []
    for held_out in dict.fromkeys(capture.sequences):
        split = cross_split(capture, held_out)
        evaluate = Evaluator.on_frames(reconstructor, split.targets)
        problem = Problem.of(capture, split, described)
        for method, s in runs:
            for k, picks in budget_picks(problem, method, budgets, [seed, s, name_seed(held_out)]):
                head = {"held_out": held_out, "method": method.name, "seed": s, "k": k}
                table = pd.DataFrame({**head, "target": split.targets})
                table[list(METRICS)] = evaluate.measure(picks).scores
                tables.append(table)
        logger.info("%s: %d targets held out", held_out, len(split.targets))
    write_table(pd.concat(tables), output, units=METRIC_UNITS, config=config)


def contenders(
    baselines: Iterable[str], weights: Mapping[str, Sequence[str | Path]]
) -> list[tuple[Method, int]]:
    """Every method with each of its seeds: the baselines', then a learned method's scorers.

    Args:
        baselines: keys of `METHODS`.
        weights: key of `POLICIES` -> its scorers, one a training seed.
    """
    runs = [(METHODS[name], s) for name in baselines for s in range(METHODS[name].seeds)]
    for name, paths in weights.items():
        runs += [(POLICIES[name].method(Scorer.load(path)), s) for s, path in enumerate(paths)]
    return runs


def budget_picks(
    problem: Problem, method: Method, budgets: Sequence[int], seed: Sequence[int]
) -> Iterator[tuple[int, np.ndarray]]:
    """Budget and picks; a nested method runs once, at the largest."""
    runs = {}
    for k in [max(budgets)] if method.nested else budgets:
        runs[k] = checked_select(method, problem, k, np.random.default_rng([*seed, k]))
    for k in budgets:
        yield k, runs[max(runs) if method.nested else k][:k]


def crosscapture(
    measured: Sequence[Mapping],
    table: str | Path,
    numbers: str | Path,
    *,
    budgets: Sequence[int],
    bootstrap: Mapping[str, int],
    facts: Mapping,
) -> None:
    """The table "Cross-capture novel view synthesis"; one measurement a room and held-out pass.

    Args:
        measured: dataset, scene, path of what `measure_crosscapture` wrote.
        table, numbers: receive LaTeX, and method, k, metric, mean, ci_low, ci_high, leads, n.
        budgets: columns.
        bootstrap: its `resamples` and `seed`.
        facts: see `captions.made_by`.
    """
    cells = pd.concat([part for item in measured for part in _measurements(item)])
    means = summarise(cells, METRICS, **bootstrap).drop(columns="dataset")
    ahead = leaders(differences(cells, list(SHOWN), METRICS, **bootstrap))
    keys = zip(means["method"], means["k"], means["metric"], strict=True)
    means["leads"] = [key in ahead for key in keys]
    write_csv(means, numbers)
    text = (
        r"\textbf{Cross-capture novel view synthesis.} Targets are the nearest half of one "
        "held-out pass of a room; candidates and proxies come from its other passes. Means over "
        f"{means['n'].max()} pairs of room and held-out pass. Bold: ahead of every other row, each "
        f"paired 95\\% interval over them excluding zero. {made_by(facts)}"
    )
    arrows = {
        name: r"$\uparrow$" if HIGHER_IS_BETTER[name] else r"$\downarrow$" for name in METRICS
    }
    head = ["Method", *[f"{name.upper()}{arrows[name]}" for name in METRICS] * len(budgets)]
    values = means.set_index(["method", "k", "metric"])
    rows = [
        [label, *(_cell(values, name, k, metric) for k in budgets for metric in METRICS)]
        for name, label in SHOWN.items()
    ]
    groups = [(f"$K{{=}}{k}$", len(METRICS)) for k in budgets]
    made = plain_table(head, rows, caption=text, label="tab:crossvideowopt", groups=groups)
    write_text(made, table)


def leaders(gaps: pd.DataFrame) -> set[tuple[str, int, str]]:
    """method, k, metric that are better than every other method, all intervals excluding zero.

    Args:
        gaps: see `fsel.report.summary.differences`.
    """
    found = set()
    for key, part in gaps.groupby(["method", "k", "metric"]):
        rises = HIGHER_IS_BETTER[key[2]]
        if ((part["ci_low"] > 0) if rises else (part["ci_high"] < 0)).all():
            found.add(key)
    return found


def _measurements(item: Mapping) -> Iterator[pd.DataFrame]:
    """dataset, scene (room and pass), draw, method, k, metrics of every held-out pass."""
    for held_out, part in pd.read_parquet(item["path"]).groupby("held_out"):
        scene = f"{item['dataset']}/{item['scene']}/{held_out}"
        # one set of measurements whatever the dataset, so that each counts once
        yield draw_means(part, METRICS).assign(dataset="crosscapture", scene=scene, draw=0)


def _cell(values: pd.DataFrame, method: str, k: int, metric: str) -> str:
    row = values.loc[(method, k, metric)]
    text = number(row["mean"], metric)
    return rf"\textbf{{{text}}}" if row["leads"] else text
