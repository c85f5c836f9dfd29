"""Run every method on a problem, and measure what its selections are worth."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from fsel import measuring
from fsel.baselines import METHODS
from fsel.capture import Capture
from fsel.evaluation import Evaluator
from fsel.files import fingerprint, write_table
from fsel.metrics import METRIC_UNITS
from fsel.problem import Problem
from fsel.reconstruct import reconstructor_of
from fsel.seeds import name_seed
from fsel.split import Split
from fsel.training.journal import Journal
from fsel.training.labelling import search_subsets, search_table

logger = logging.getLogger(__name__)


def select(
    folder: str | Path,
    splits: Sequence[str | Path],
    weights: Sequence[str | Path],
    outputs: Sequence[str | Path],
    *,
    budgets: Sequence[int],
    seeds: Sequence[int],
    config: str,
) -> None:
    """Every method's picks at every budget of every draw, one row a pick.

    Args:
        folder: a canonical capture with its descriptors.
        splits: split.parquet, one a draw.
        weights: scorers, see `fsel.measuring.runs`.
        outputs: one a draw: method, pool, seed, k, order, frame, name, seconds; `pool` is where the
            method may pick from, `candidates` (P) or `observed` (P and O).
        budgets: frames to pick.
        seeds: one a draw.
        config: digest of the parameters.
    """
    contenders = measuring.runs(METHODS.values(), weights)
    for split, output, seed in zip(splits, outputs, seeds, strict=True):
        problem = Problem.load(folder, split)
        picks = measuring.select(problem, contenders, budgets, measuring.chance(seed))
        write_table(picks, output, units=measuring.PICK_UNITS, config=config)


def evaluate(
    folder: str | Path,
    splits: Sequence[str | Path],
    selections: Sequence[str | Path],
    outputs: Sequence[str | Path],
    *,
    reconstruction: Mapping,
    config: str,
) -> None:
    """Reconstruct every selection and compare it with the held-out targets of its draw.

    The draws share one reconstructor, and with it the matching costs that they have in common.

    Args:
        folder: a canonical capture.
        splits: split.parquet, one a draw.
        selections: what `select` wrote, one a draw.
        outputs: one a draw: method, seed, k, target, metrics and costs.
        reconstruction: the config's section.
        config: digest of the parameters.
    """
    reconstructor = reconstructor_of(Capture.load(folder), reconstruction)
    for split, picked, output in zip(splits, selections, outputs, strict=True):
        logger.info("%s", picked)
        evaluator = Evaluator.on_frames(reconstructor, Split.load(split).targets)
        table = measuring.measure(evaluator, pd.read_parquet(picked))
        write_table(table, output, units=measuring.MEASURED_UNITS, config=config)


def search_oracle(
    folder: str | Path,
    split: str | Path,
    subsets: str | Path,
    output: str | Path,
    *,
    search: Mapping,
    reconstruction: Mapping,
    seed: int,
    inputs: Iterable[str | Path],
    config: str,
) -> None:
    """The genetic search on an evaluation problem, and random search of equal budget beside it.

    Both score subsets on the proxies and are then measured on the targets (Appendix D.3).

    Args:
        folder: a canonical capture with its descriptors.
        split: split.parquet of the draw.
        subsets, output: receive every subset, on the proxies, and the best two, on the targets.
        search, reconstruction: the config's sections.
        seed: of the draw.
        inputs, config: files and digest of parameters that the evaluations depend on.
    """
    problem, parts = Problem.load(folder, split), Split.load(split)
    reconstructor = reconstructor_of(problem.capture, reconstruction)
    on_targets = Evaluator.on_frames(reconstructor, parts.targets)
    searched, picks = [], []
    with Journal(subsets, fingerprint(inputs, {"config": config})) as journal:
        on_proxies = journal.remember("p", Evaluator.on_frames(reconstructor, parts.proxies))
        for name, labeller in (("search", "genetic"), ("random_search", "random")):
            rng = np.random.default_rng([seed, name_seed(name)])
            result = search_subsets(on_proxies, problem, parts, labeller, search, rng)
            search = {**search, "evaluations": len(result.subsets)}
            searched.append(search_table(result, search["stored"]).assign(method=name))
            fittest = result.subsets[result.best(1)[0]]
            head = {"method": name, "seed": 0, "k": search["k"]}
            picks.append(pd.DataFrame({**head, "frame": fittest}))
        measured = measuring.measure(on_targets, pd.concat(picks))
        write_table(measured, output, units=measuring.MEASURED_UNITS, config=config)
        write_table(pd.concat(searched), subsets, units=METRIC_UNITS, config=config)
