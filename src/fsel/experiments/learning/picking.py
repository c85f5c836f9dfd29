"""What learned networks pick on scenes that they have not seen, and what the picks are worth."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from fsel import measuring
from fsel.capture import Capture
from fsel.experiments.learning.cases import LEARNERS
from fsel.experiments.learning.lessons import Score, walked
from fsel.experiments.learning.network import Learned, Networks, load
from fsel.experiments.learning.pairs import RULE, Pairs
from fsel.files import read_table, write_table
from fsel.measuring import Picks, Run
from fsel.problem import Problem
from fsel.reconstruct import reconstructor_of
from fsel.selector import pretrained

BY = ["draw", *measuring.SELECTION]
METRIC = ("psnr",)


def select_learned(
    folder: str | Path,
    splits: Sequence[str | Path],
    networks: Sequence[str | Path],
    picks: str | Path,
    *,
    budgets: Sequence[int],
    config: str,
) -> None:
    """Picks of every network, and of the rule, at every budget of every draw.

    Args:
        folder: a canonical capture with its descriptors.
        splits: split.parquet, one a draw.
        networks: what `fsel.experiments.learning.learn` wrote.
        picks: receives draw, method, seed, k, frame.
        budgets: frames to pick; progress is an input, so that each has a walk of its own.
        config: digest of the parameters.
    """
    loaded: dict[str, Sequence[Learned]] = {}
    for path in networks:
        loaded |= load(path)
    rule = Run(pretrained.method(RULE.name), 0)
    tables = []
    for draw, split in enumerate(splits):
        problem = Problem.load(folder, split)
        pairs = Pairs.of(problem)
        for run in measuring.picks_at(problem, rule, budgets, measuring.chance(0)):
            tables.append(_rows(draw, RULE.name, 0, run))
        for name, seed, score in _scores(loaded):
            for k in budgets:
                rows = walked(pairs, k, score).picks
                tables.append(_rows(draw, name, seed, Picks(k, pairs.prepared.pool[rows], 0.0)))
    write_table(pd.concat(tables), picks, units={}, config=config)


def _scores(networks: Networks) -> Iterator[tuple[str, int, Score]]:
    """Name, seed and score of every scorer; those of an average are one."""
    for name, seeds in networks.items():
        if name in LEARNERS and LEARNERS[name].together:
            yield name, 0, lambda features, all_=seeds: mean_score(all_, features)
        else:
            for seed, network in enumerate(seeds):
                yield name, seed, network.scores


def mean_score(networks: Sequence[Learned], features: np.ndarray) -> np.ndarray:
    """(n,) mean of the networks' scores of (n, 1 + F) inputs."""
    return np.mean([network.scores(features) for network in networks], axis=0)


def _rows(draw: int, name: str, seed: int, picks: Picks) -> pd.DataFrame:
    head = {"draw": draw, "method": name, "seed": seed, "k": picks.k}
    return pd.DataFrame({**head, "frame": picks.frames})


def evaluate_learned(
    folder: str | Path,
    splits: Sequence[str | Path],
    picks: str | Path,
    evaluation: str | Path,
    *,
    reconstruction: Mapping,
    budgets: Sequence[int],
    config: str,
) -> None:
    """What those picks are worth; equal picks are reconstructed once.

    Args:
        folder: a canonical capture.
        splits: split.parquet, one a draw; picks of further draws are left out.
        picks: what `select_learned` wrote.
        evaluation: receives draw, and the columns of `fsel.measuring.measure`.
        reconstruction: what judges, as the config's section.
        budgets: whose picks are judged.
        config: digest of the parameters.
    """
    reconstructor = reconstructor_of(Capture.load(folder), reconstruction)
    found = read_table(picks)
    asked = found[found["k"].isin(budgets) & (found["draw"] < len(splits))]
    table = measuring.measure_draws(reconstructor, splits, asked, BY, METRIC)
    write_table(table, evaluation, units=measuring.measured_units(METRIC), config=config)
