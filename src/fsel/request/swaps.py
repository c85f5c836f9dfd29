"""Picks made better by swaps that real reconstructions judge, for as long as a person waits.

Not in the paper. Its search (section 3.4) judges subsets on frames that no subset may hold, before
any capture is met. Here the capture is at hand, and every observed frame may be picked, see
`fsel.request.judges`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from fsel.data.problem import Problem
from fsel.data.subsets import subset_key
from fsel.reconstruct import Reconstructor, reconstructor_of
from fsel.request.judges import Judges, Unpicked
from fsel.request.refine import JUDGES, Refine, Swapped
from fsel.utils.wording import counted

SHARE = 0.5  # of the swaps that bring a neighbour in capture order of the frame that leaves
NEIGHBOURS = 6  # free frames around it
REGION = 8  # frames nearest to each target, which the other swaps bring
LEAST_PICKS = 3  # without a judge that is picked, two are left to reconstruct from
JUDGE = {"name": "splats", "long_side": 64, "settings": JUDGES["splats"]}
TRIES = 20  # proposals for each pick, in a row, that were met before: then the search ends


def swaps(
    judge: Callable[[np.ndarray], float],
    picks: np.ndarray,
    pool: np.ndarray,
    region: np.ndarray,
    rng: np.random.Generator,
) -> Iterator[Swapped]:
    """Hill climbing by single swaps: what is judged better is kept.

    One frame of the picks leaves; half of the time a neighbour of it in capture order comes, else a
    frame of the region.

    Args:
        judge: (K,) frames -> a number, more is better.
        picks: (K,) distinct members of the pool, to start from.
        pool: (P,) frames that may be picked, ascending.
        region: (R,) frames of the pool near the targets.
        rng: the only source of chance.

    Yields:
        The best so far, after every subset tried; the first is the start. It ends where no swap
        that was not tried is found.
    """
    start = best = judge(picks)
    met = {subset_key(picks)}
    yield Swapped(picks, 0.0, 1)
    missed = 0
    while missed < TRIES * len(picks):
        swapped = _swapped(picks, pool, region, rng)
        if swapped is None or subset_key(swapped) in met:
            missed += 1
            continue
        missed = 0
        met.add(subset_key(swapped))
        score = judge(swapped)
        if score > best:
            best, picks = score, swapped
        yield Swapped(picks, best - start, len(met))


def problem_swaps(
    reconstructor: Reconstructor, problem: Problem, picks: np.ndarray, rng: np.random.Generator
) -> Iterator[Swapped]:
    """Swaps of a problem's picks among its observed frames, judged by those near its targets.

    Where nobody said what will be rendered, all frames judge that are not picked.

    Args:
        reconstructor: bound to the problem's capture, at the reconstruction size.
        problem: targets, by their poses alone, and observed frames.
        picks: (K,) observed frames, K >= 3.
        rng: the only source of chance.
    """
    if problem.whole:
        unpicked = Unpicked(reconstructor, problem, picks)
        return swaps(unpicked, picks, problem.observed, problem.observed, rng)
    judges = Judges(reconstructor, problem, picks)
    region = np.unique(judges.nearest[:, :REGION])
    return swaps(judges, picks, problem.observed, region, rng)


def refined(problem: Problem, picks: np.ndarray, refine: Refine, seed: int) -> Swapped:
    """The best of swaps in some seconds, judged by the reconstructor that is named, at 64 pixels.

    Args:
        problem: see `problem_swaps`; its capture's images are read.
        picks: (K,) observed frames.
        refine: for how long, and by what.
        seed: of the swaps that are tried; which are reached depends on the machine's speed.

    Raises:
        ValueError: for fewer than three picks.
    """
    if len(picks) < LEAST_PICKS:
        raise ValueError(f"refine: {counted(len(picks), 'pick')}; allowed: {LEAST_PICKS} or more")
    started = time.perf_counter()
    judge = JUDGE | {"name": refine.reconstructor, "settings": JUDGES[refine.reconstructor]}
    reconstructor = reconstructor_of(problem.capture, judge)
    best = Swapped(picks, 0.0, 0, refine.reconstructor)
    for best in problem_swaps(reconstructor, problem, picks, np.random.default_rng(seed)):
        best = replace(best, reconstructor=refine.reconstructor)
        gone = time.perf_counter() - started
        if not refine.told(best, gone) or gone > refine.seconds:
            break
    return best


def _swapped(
    picks: np.ndarray, pool: np.ndarray, region: np.ndarray, rng: np.random.Generator
) -> np.ndarray | None:
    """One frame replaced; None where all of the region is picked."""
    place = int(rng.integers(len(picks)))
    if rng.random() < SHARE:
        free = np.setdiff1d(pool, picks)
        free = free[np.argsort(np.abs(free - picks[place]), kind="stable")[:NEIGHBOURS]]
    else:
        free = np.setdiff1d(region, picks)
    if len(free) == 0:
        return None
    swapped = picks.copy()
    swapped[place] = rng.choice(free)
    return swapped
