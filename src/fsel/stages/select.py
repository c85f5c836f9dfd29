"""Run every method on every problem of a capture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from fsel.captures.layouts.dl3dv import read_protocol
from fsel.core.files import File, Files, read_columns, stacked, write_table
from fsel.core.problem import Problem
from fsel.evaluation import measuring
from fsel.features.static import with_features
from fsel.selectors.baselines import METHODS


def select(
    folder: File,
    splits: Files,
    features: Files,
    weights: Files,
    selections: Files,
    *,
    budgets: Sequence[int],
    seeds: Sequence[int],
    protocol: Mapping[str, str] | None = None,
    config: str,
) -> None:
    """Every method's picks at every budget of every draw, one row a pick.

    Args:
        features: what `fsel.stages.features` wrote of them, one a draw.
        selections: one a draw, see `fsel.evaluation.measuring.select`.
        protocol: whose list is one more method, see `fsel.stages.split`.
    """
    contenders = measuring.runs(METHODS.values(), weights)
    for split, table, path, seed in zip(splits, features, selections, seeds, strict=True):
        problem = with_features(Problem.load(folder, split), read_columns(table), table)
        picks = measuring.select(problem, contenders, budgets, measuring.rng_by_name(seed))
        if protocol:
            listed = read_protocol(names=problem.capture.names, **protocol)
            known = [k for k in budgets if k in listed.inputs]
            run = measuring.Run(listed.method, 0)
            more = measuring.select(problem, [run], known, measuring.rng_by_name(seed))
            picks = stacked([picks, more])
        write_table(picks, path, units=measuring.PICK_UNITS, config=config)
