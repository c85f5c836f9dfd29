"""Runs of methods, their picks at every budget, and what the picks are worth.

`runs` lists who picks, `select` writes down what they pick, `measure` scores what was written down.
Other tables and other reconstructors measure the same picks again.
"""

from __future__ import annotations

import logging
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fsel.core.files import Columns, repeated, stacked
from fsel.core.names import name_seed
from fsel.core.problem import Method, Problem, checked_select
from fsel.evaluation.evaluator import COSTS, Evaluator
from fsel.metrics import METRICS, Metrics, units
from fsel.selectors import pretrained
from fsel.selectors.policies import KNOWN

if TYPE_CHECKING:
    import pandas as pd

logger = logging.getLogger(__name__)

PICK_UNITS = {"seconds": "s, of the whole run that these picks are a prefix of"}
COST_UNITS = {"fit_seconds": "s", "render_seconds": "s", "bytes": "bytes", "peak_bytes": "bytes"}
SELECTION = ("method", "seed", "k")  # what tells one selection of a problem from another


class Run(NamedTuple):
    """A method, and the number of its seed: 0, 1, ..."""

    method: Method
    seed: int


class Picks(NamedTuple):
    """Picks of a run at one budget: (k,) int64 frames in pick order, seconds of the whole run."""

    k: int
    frames: np.ndarray
    seconds: float


RngFactory = Callable[[Run, int], np.random.Generator]
"""(run, k) -> the random generator of a run that picks k frames."""


def runs(methods: Iterable[Method], weights: Iterable[str | Path] = ()) -> list[Run]:
    """List every method with each of its seeds, then the learned methods, one run a scorer;
    ValueError for a scorer of none of `fsel.selectors.policies.KNOWN`."""
    untrained = [Run(method, seed) for method in methods for seed in range(method.seeds)]
    return untrained + learned_runs(weights)


def learned_runs(weights: Iterable[str | Path]) -> list[Run]:
    """List one run a scorer, in the order of `KNOWN`, then of the files; arguments as in `runs`."""
    learned: list[Run] = []
    seeds: Counter[str] = Counter()
    for path in weights:
        method = pretrained.own(path)
        learned.append(Run(method, seeds[method.name]))
        seeds[method.name] += 1
    order = list(KNOWN)
    return sorted(learned, key=lambda run: order.index(run.method.name))


def rng_by_name(seed: int) -> RngFactory:
    """Seed generators by the problem's seed and the run's names: another method changes none."""
    return lambda run, k: np.random.default_rng(name_seed(seed, run.method.name, run.seed, k))


def rng_by_draw(seed: int, draw: int) -> RngFactory:
    """Make generators seeded by numbers: all methods of one seed and budget start alike."""
    return lambda run, k: np.random.default_rng([seed, draw, run.seed, k])


def picks_at(
    problem: Problem, run: Run, budgets: Sequence[int], rng_of: RngFactory
) -> Iterator[Picks]:
    """Yield the picks of a run at every budget; a nested method runs once, at the largest, and its
    other picks are the beginning of those."""
    made = {}
    for k in [max(budgets)] if run.method.nested else budgets:
        rng = rng_of(run, k)
        started = time.perf_counter()
        frames = checked_select(run.method, problem, k, rng)
        made[k] = frames, time.perf_counter() - started
    for k in budgets:
        frames, seconds = made[max(budgets) if run.method.nested else k]
        yield Picks(k, frames[:k], seconds)


def select(
    problem: Problem, runs: Iterable[Run], budgets: Sequence[int], rng_of: RngFactory
) -> dict[str, np.ndarray]:
    """Pick frames by every run at every budget, one row a pick in `PICK_UNITS`: method, pool, seed,
    k, order, frame, name, seconds; `all` takes `Problem.sequence`."""
    parts: list[Columns] = []
    for run in runs:
        method = run.method
        sizes = [len(problem.sequence)] if method.name == "all" else budgets
        for k, frames, seconds in picks_at(problem, run, sizes, rng_of):
            same = {"method": method.name, "pool": method.pool, "seed": run.seed, "k": k}
            names = [problem.capture.names[frame] for frame in frames]
            rows = {"order": range(k), "frame": frames, "name": names}
            parts.append(repeated(same, k) | rows | repeated({"seconds": seconds}, k))
    return stacked(parts)


def measure(
    evaluator: Evaluator, picks: Columns | pd.DataFrame, by: Sequence[str] = SELECTION
) -> dict[str, np.ndarray]:
    """Measure what picks are worth, one row a selection and view: the columns of `by`, which tell
    one selection from another, in order of their values, then `measured`'s."""
    parts: list[Columns] = []
    frames: defaultdict[tuple[Any, ...], list[int]] = defaultdict(list)
    columns = (np.asarray(picks[name]).tolist() for name in (*by, "frame"))
    for *values, frame in zip(*columns, strict=True):
        frames[tuple(values)].append(frame)
    for key, subset in sorted(frames.items()):
        rows = measured(evaluator, np.array(subset))
        first = next(iter(evaluator.metrics))
        logger.info("%s: %s %.3f", key, first, rows[first].mean())
        same = repeated(dict(zip(by, key, strict=True)), len(evaluator.frames))
        parts.append(same | rows)
    return stacked(parts)


def measured(evaluator: Evaluator, subset: np.ndarray) -> dict[str, Any]:
    """Measure what one subset is worth, one row a view: target (the frame rendered), the
    evaluator's metrics, and `COSTS`, in `measured_units`."""
    result = evaluator.measure(subset)
    rows: dict[str, Any] = {"target": evaluator.frames}
    rows |= zip(evaluator.metrics, result.scores.T, strict=True)
    return rows | {cost: [getattr(result, cost)] * len(evaluator.frames) for cost in COSTS}


def measured_units(metrics: Metrics = METRICS) -> dict[str, str]:
    """Return column -> unit of what `measured` returns."""
    return {**units(metrics), **COST_UNITS}
