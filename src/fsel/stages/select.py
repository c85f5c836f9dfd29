"""Run every method on every problem of a capture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from fsel.core.files import File, Files, read_columns, write_table
from fsel.core.geometry import farthest_views
from fsel.core.problem import Method, Problem
from fsel.evaluation import measuring
from fsel.features.static import with_features
from fsel.selection.problem import request_problem
from fsel.selection.targets import targets_of
from fsel.selectors.baselines import METHODS, PRACTICE


def select(
    folder: File,
    splits: Files,
    features: Files,
    weights: Files,
    selections: Files,
    *,
    budgets: Sequence[int],
    seeds: Sequence[int],
    practice: bool = False,
    hold_out: Mapping | None = None,
    config: str,
) -> None:
    """Write every method's picks at every budget of every draw, one row a pick.

    Args:
        features: what `fsel.stages.features` wrote of them, one a draw.
        selections: one a draw, see `fsel.evaluation.measuring.select`.
        practice: whether the baselines of `PRACTICE` are among the methods.
        hold_out: the config's section. With `every`, no method knows the targets, and all begin
            with `first` frames: the first one, and those farthest from it and each other.
    """
    methods = [*METHODS.values(), *(PRACTICE.values() if practice else ())]
    runs = measuring.runs(methods, weights)
    first = hold_out["first"] if hold_out and hold_out["every"] else 0
    if first:
        runs = [run._replace(method=beginning(run.method)) for run in runs]
    for split, table, path, seed in zip(splits, features, selections, seeds, strict=True):
        problem = with_features(Problem.load(folder, split), read_columns(table), table)
        if first:
            pool, centers = problem.observed, problem.capture.centers
            problem = unaimed(problem, pool, farthest_views(pool, centers, first, pool[0]))
        picks = measuring.select(problem, runs, budgets, measuring.rng_by_name(seed))
        write_table(picks, path, units=measuring.PICK_UNITS, config=config)


def unaimed(problem: Problem, pool: np.ndarray, first: np.ndarray) -> Problem:
    """Return the problem of a whole capture: (n,) frames may be picked, some of them first."""
    capture, targets = problem.capture, targets_of(problem.capture, None)
    others = np.setdiff1d(np.arange(len(capture)), pool)
    targets = replace(targets, views=capture.view(pool), never=others, always=first)
    return request_problem(capture, targets, problem.sharpness, None, problem.descriptors)


def beginning(method: Method) -> Method:
    """Return a method that begins with `Problem.fixed_picks`, whether or not it looks at them."""

    def picked(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
        first = problem.fixed_picks
        rest = unaimed(problem, np.setdiff1d(problem.candidates, first), first[:0])
        return np.concatenate([first, method.select(rest, k - len(first), rng)])

    return method if method.begins else replace(method, select=picked)
