"""Labels for requests: subsets of all observed frames, judged on the views that will be rendered.

Not in the paper, whose labels are subsets of P judged on proxies (section 3.4). Labels are made
offline, on training scenes, where the images of the targets may be looked at. Single steps mislead,
since a frame's worth shows beside its partners, so that whole subsets are searched: by swaps from
good starts. Those that were tried and rejected are kept with their scores, as what to rank below.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from fsel.baselines.nearest import nearest
from fsel.capture import Capture
from fsel.problem import Problem
from fsel.request.judges import nearest_to_targets
from fsel.request.swaps import REGION, swaps
from fsel.seeds import name_seed
from fsel.selector import pretrained
from fsel.split import Split, coverage_split
from fsel.subsets import subset_key
from fsel.training.search import GeneticSettings, genetic_search

Judge = Callable[[np.ndarray], float]
"""(K,) ascending frames -> PSNR in dB on the targets."""

RULE, NEAREST, EXCHANGED, GENETIC = "fsel", "nearest", "exchanged", "genetic"
SHARE = 3  # an exchanged start replaces one in so many of the rule's picks
TRIED = 3  # evaluations that are timed


@dataclass(frozen=True)
class Request:
    """What is asked of a scene.

    Attributes:
        coverage: per cent of the capture that targets are drawn from: spread or concentrated.
        draw: number of the draw of targets.
        k: frames to pick.
    """

    coverage: int
    draw: int
    k: int

    def split(self, capture: Capture, seed: int) -> Split:
        """Targets, proxies and candidates.

        Args:
            capture: the scene.
            seed: of the scene.
        """
        return coverage_split(capture, self.coverage, name_seed(seed, self.draw))


def requests_of(
    coverages: Sequence[int], draws: int, budgets: Sequence[int], seed: int
) -> list[Request]:
    """Every coverage level of every draw, each with a budget drawn from `budgets`.

    A draw more changes none before it.
    """
    found = []
    for draw in range(draws):
        rng = np.random.default_rng([seed, draw])
        found += [Request(level, draw, int(rng.choice(budgets))) for level in coverages]
    return found


def starts(
    problem: Problem, k: int, exchanged: int, rng: np.random.Generator
) -> list[tuple[str, np.ndarray]]:
    """Where swaps begin: the rule's picks, Nearest, and the rule's with a third exchanged.

    Args:
        problem: the selection problem.
        k: frames to pick.
        exchanged: how many starts of the last kind; the frames that come are drawn at random.
        rng: the only source of chance.
    """
    pool = problem.observed
    rule = pretrained.method(RULE).select(problem, k, rng)
    found = [(RULE, rule), (NEAREST, nearest(problem, pool, k))]
    for _ in range(exchanged):
        kept = rng.permutation(rule)[max(1, k // SHARE) :]
        come = rng.choice(np.setdiff1d(pool, rule), size=k - len(kept), replace=False)
        found.append((EXCHANGED, np.concatenate([kept, come])))
    return found


def search_request(
    judge: Judge, problem: Problem, k: int, settings: Mapping, rng: np.random.Generator
) -> pd.DataFrame:
    """Swaps from every start, an equal part of the evaluations each; then the paper's search.

    Args:
        judge: of subsets.
        problem: the selection problem; every observed frame may be picked.
        k: frames to pick.
        settings: evaluations (of the swaps), exchanged, generations (of the paper's search; 0 for
            none).
        rng: the only source of chance.

    Returns:
        start, subset, psnr, rank: one row a distinct subset, in the order of evaluation; `start` is
        where the swaps that met it first began, or `genetic`; rank 0 is the best.
    """
    begun = starts(problem, k, settings["exchanged"], rng)
    region = np.unique(nearest_to_targets(problem)[:, :REGION])
    known = _Known(judge)
    for left, (name, picks) in zip(range(len(begun), 0, -1), begun, strict=True):
        most = len(known.rows) + (settings["evaluations"] - len(known.rows)) // left
        known.start = name
        for _ in swaps(known, picks, problem.observed, region, rng):
            if len(known.rows) >= most:
                break
    if settings["generations"]:
        known.start, centers = GENETIC, problem.capture.centers
        genetic_search(known.metrics, problem.observed, region, centers, k, rng, genetic(settings))
    table = pd.DataFrame(
        [(start, list(key), score) for key, (start, score) in known.rows.items()],
        columns=["start", "subset", "psnr"],
    )
    order = np.argsort(-table["psnr"].to_numpy(), kind="stable")
    table["rank"] = np.argsort(order, kind="stable")
    return table


def genetic(settings: Mapping) -> GeneticSettings:
    """The paper's search, with so many generations; `settings` as of `search_request`."""
    return GeneticSettings(generations=settings["generations"])


def most_subsets(settings: Mapping) -> int:
    """That a request may have evaluated; `settings` as of `search_request`."""
    after = genetic(settings)
    more = after.population * (after.generations + 1) if after.generations else 0
    return settings["evaluations"] + more


@dataclass
class _Known:
    """A judge with a memory.

    Attributes:
        judge: of subsets.
        start: where the swaps that ask now began.
        rows: subset -> the start that met it first, and its score.
    """

    judge: Judge
    start: str = ""
    rows: dict[tuple[int, ...], tuple[str, float]] = field(default_factory=dict)

    def __call__(self, picks: np.ndarray) -> float:
        key = subset_key(picks)
        if key not in self.rows:
            self.rows[key] = self.start, self.judge(np.array(key, np.int64))
        return self.rows[key][1]

    def metrics(self, subset: np.ndarray) -> np.ndarray:
        """(3,) as searches ask for them: the score alone tells subsets apart."""
        return np.array([self(subset), 0.0, 0.0])


def seconds_each(judge: Judge, pool: np.ndarray, k: int) -> float:
    """What an evaluation takes before subsets share much; the first, which compiles, not counted.

    Args:
        judge: of subsets.
        pool: frames that may be picked.
        k: of the subsets that are timed, which are random.
    """
    rng, spent = np.random.default_rng(0), []
    for _ in range(TRIED + 1):
        subset = np.sort(rng.choice(pool, k, replace=False))
        started = time.perf_counter()
        judge(subset)
        spent.append(time.perf_counter() - started)
    return float(np.mean(spent[1:]))
