"""Swaps of picks that real reconstructions score, for as long as a person waits.

Not in the paper. Its search (section 3.4) scores subsets on frames that no subset may hold, before
any capture is met. Here the capture is at hand, and every observed frame may be picked, see
`fsel.selection.estimated_gain`. Where nobody says what will be rendered, swaps are kept only where
frames that scored none of them confirm it by two reconstructors, as in `fsel.selection.trials`.
What this gains is in docs/results/refine.md.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from fsel.core.problem import Problem
from fsel.core.subsets import subset_key
from fsel.core.wording import counted
from fsel.reconstruct import Reconstructor, reconstructor_of
from fsel.selection.estimated_gain import EstimatedGain
from fsel.selection.patience import Patience
from fsel.selection.refine import SETTINGS, Refine, Swapped
from fsel.selection.small_fits import small_fits
from fsel.selection.trials import Race
from fsel.selection.unpicked_gain import UnpickedGain, halves

SHARE = 0.5  # of the swaps that bring a neighbour in capture order of the frame that leaves
NEIGHBOURS = 6  # free frames around it
REGION = 8  # frames nearest to each target, which the other swaps bring
LEAST_PICKS = 3  # without a validation frame that is picked, two are left to reconstruct from
SIDE = 64  # pixels
TRIES = 20  # proposals for each pick, in a row, that were met before: then the search ends
BEGAN, AFTER = "began with", "swapped"


def swaps(
    worth: Callable[[np.ndarray], float],
    picks: np.ndarray,
    pool: np.ndarray,
    region: np.ndarray,
    rng: np.random.Generator,
) -> Iterator[Swapped]:
    """Climb by single swaps: what is worth more is kept.

    One frame of the picks leaves; half of the time a neighbour of it in capture order comes, else a
    frame of the region.

    Args:
        worth: (K,) frames -> a number, more is better.
        picks: (K,) distinct members of the pool, to start from.
        pool: (P,) frames that may be picked, ascending.
        region: (R,) frames of the pool near the targets.
        rng: the only source of chance.

    Yields:
        The best so far, after every subset tried; the first is the start. It ends where no swap
        that was not tried is found.
    """
    start = best = worth(picks)
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
        score = worth(swapped)
        if score > best:
            best, picks = score, swapped
        yield Swapped(picks, best - start, len(met))


def problem_swaps(
    reconstructor: Reconstructor, problem: Problem, picks: np.ndarray, rng: np.random.Generator
) -> Iterator[Swapped]:
    """Swap a problem's picks among its observed frames, scored on those near its targets.

    Where nobody said what will be rendered, they are scored on half of the frames that are not
    picked.

    Args:
        reconstructor: bound to the problem's capture, at the reconstruction size.
        problem: targets, by their poses alone, and observed frames.
        picks: (K,) observed frames, K >= 3.
        rng: the only source of chance.
    """
    if problem.whole:
        unpicked = UnpickedGain(reconstructor, halves(problem.observed, picks), picks)
        return swaps(unpicked, picks, problem.observed, problem.observed, rng)
    gain = EstimatedGain(reconstructor, problem, picks)
    region = np.unique(gain.nearest[:, :REGION])
    return swaps(gain, picks, problem.observed, region, rng)


def scoring(name: str) -> dict[str, Any]:
    """Section of a configuration: a reconstructor as it scores swaps."""
    return {"name": name, "long_side": SIDE, "settings": SETTINGS[name]}


def refined(problem: Problem, picks: np.ndarray, refine: Refine, seed: int) -> Swapped:
    """Return the best of swaps in some seconds, scored as `refine` says, at 64 pixels.

    Args:
        problem: see `problem_swaps`; its capture's images are read.
        picks: (K,) observed frames.
        refine: for how long.
        seed: of the swaps that are tried; which are reached depends on the machine's speed.

    Raises:
        ValueError: for fewer than three picks.
    """
    if len(picks) < LEAST_PICKS:
        raise ValueError(f"refine: {counted(len(picks), 'pick')}; allowed: {LEAST_PICKS} or more")
    started = None
    name = refine.reconstructor or ("gaussians" if problem.whole else "splats")
    reconstructor = reconstructor_of(problem.capture, scoring(name))
    best = Swapped(picks, 0.0, 0, name)
    for best in problem_swaps(reconstructor, problem, picks, np.random.default_rng(seed)):
        best = replace(best, reconstructor=name)
        started = started or time.perf_counter()  # once the first reconstruction has compiled
        gone = time.perf_counter() - started
        if not refine.progress(best, gone) or gone > refine.seconds:
            break
    return confirmed(problem, picks, best) if problem.whole else best


def confirmed(problem: Problem, picks: np.ndarray, swapped: Swapped) -> Swapped:
    """Take swaps back, unless frames that scored none of them confirm them.

    The picks before and after are reconstructed with new seeds and compared as selections that are
    tried, see `fsel.selection.trials`.

    Args:
        problem: of a whole capture.
        picks: (K,) before any swap.
        swapped: what swaps made of them.
    """
    if subset_key(swapped.picks) == subset_key(picks):
        return swapped
    fresh = halves(problem.observed, picks)[1]
    selections = {BEGAN: np.sort(picks), AFTER: np.sort(swapped.picks)}
    score = small_fits(problem.capture, fresh, selections)

    def anew(frames: np.ndarray, seed: int | None) -> np.ndarray:
        return score(frames, None if seed is None else seed + 1)  # swaps are scored with seed 0

    outcome = Race(anew, selections, fresh).run(1, Patience(float("inf")))
    kept = outcome.kept == AFTER
    return replace(
        swapped, picks=swapped.picks if kept else picks, fresh=outcome.trials[1], kept=kept
    )


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
