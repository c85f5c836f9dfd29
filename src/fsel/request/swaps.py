"""Picks made better by swaps that real reconstructions judge, for as long as a person waits.

Not in the paper. Its search (section 3.4) judges subsets on frames that no subset may hold, before
any capture is met. Here the capture is at hand, and every observed frame may be picked: the frames
near the targets judge as long as they are not picked themselves, so that no frame judges itself.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from fsel.geometry import pose_distance
from fsel.metrics import score_views
from fsel.problem import Problem
from fsel.reconstruct import Reconstructor, reconstructor_of
from fsel.request.refine import Refine, Swapped

SHARE = 0.5  # of the swaps that bring a neighbour in capture order of the frame that leaves
NEIGHBOURS = 6  # free frames around it
JUDGING = 3  # frames nearest to each target, which judge
REGION = 8  # frames nearest to each target, which the other swaps bring
METRIC = ("psnr",)
LEAST_PICKS = 3  # without a judge that is picked, two are left to reconstruct from
JUDGE = {"name": "splats", "long_side": 64, "settings": {}}
TRIES = 20  # of proposals that were met before, until the neighbourhood counts as searched


@dataclass(frozen=True)
class Judges:
    """PSNR of observed frames that are not picked, over what the first picks gave them.

    Attributes:
        reconstructor: bound to the capture.
        frames: (J,) int64 distinct frames, ascending.
        images: (J, h, w, 3) uint8 of them, at the reconstruction size.
        base: (J,) PSNR of each by the first picks without itself. Without it, subsets that hold the
            frames that are hard to render would look better than they are.
    """

    reconstructor: Reconstructor
    frames: np.ndarray
    images: np.ndarray
    base: np.ndarray

    @classmethod
    def of(cls, reconstructor: Reconstructor, frames: np.ndarray, picks: np.ndarray) -> Judges:
        """Frames of the reconstructor's capture, each counted once, and (K,) picks, K >= 3."""
        distinct = np.unique(frames)
        images = np.asarray(reconstructor.capture.images[distinct])
        judges = cls(reconstructor, distinct, images, np.zeros(len(distinct)))
        picked = np.isin(distinct, picks)
        judges.base[~picked] = judges.scores(picks, ~picked)
        for row in np.flatnonzero(picked):
            alone = np.arange(len(distinct)) == row
            judges.base[row] = judges.scores(np.setdiff1d(picks, distinct[row]), alone)[0]
        return judges

    def __call__(self, picks: np.ndarray) -> float:
        """Of (K,) distinct picks, in any order: the mean gain in dB; 0 where all are picked."""
        free = ~np.isin(self.frames, picks)
        return float((self.scores(picks, free) - self.base[free]).mean()) if free.any() else 0.0

    def scores(self, picks: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """PSNR of some of the frames, (J,) bool, rendered from a reconstruction of the picks."""
        if not rows.any():
            return np.zeros(0)
        model = self.reconstructor.fit(np.sort(picks))
        rendered = model.render(self.reconstructor.capture.view(self.frames[rows]))
        return score_views(rendered, self.images[rows], metrics=METRIC)[:, 0]


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
    met = {_key(picks)}
    yield Swapped(picks, 0.0, 1)
    missed = 0
    while missed < TRIES * len(picks):
        swapped = _swapped(picks, pool, region, rng)
        if swapped is None or _key(swapped) in met:
            missed += 1
            continue
        missed = 0
        met.add(_key(swapped))
        score = judge(swapped)
        if score > best:
            best, picks = score, swapped
        yield Swapped(picks, best - start, len(met))


def problem_swaps(
    reconstructor: Reconstructor, problem: Problem, picks: np.ndarray, rng: np.random.Generator
) -> Iterator[Swapped]:
    """Swaps of a problem's picks among its observed frames, judged by those near its targets.

    Args:
        reconstructor: bound to the problem's capture, at the reconstruction size.
        problem: targets, by their poses alone, and observed frames.
        picks: (K,) observed frames, K >= 3.
        rng: the only source of chance.
    """
    nearest = nearest_to_targets(problem)
    judge = Judges.of(reconstructor, nearest[:, :JUDGING], picks)
    return swaps(judge, picks, problem.observed, np.unique(nearest[:, :REGION]), rng)


def nearest_to_targets(problem: Problem) -> np.ndarray:
    """(T, P) observed frames, a row a target, the nearest first."""
    capture, pool, targets = problem.capture, problem.observed, problem.targets
    distance = pose_distance(
        targets.centers, targets.axes, capture.centers[pool], capture.axes[pool]
    )
    return pool[np.argsort(distance, axis=1, kind="stable")]


def refined(problem: Problem, picks: np.ndarray, refine: Refine, seed: int) -> Swapped:
    """The best of swaps in some seconds, judged by `splats` at 64 pixels.

    Args:
        problem: see `problem_swaps`; its capture's images are read.
        picks: (K,) observed frames.
        refine: for how long.
        seed: of the swaps that are tried; which are reached depends on the machine's speed.

    Raises:
        ValueError: for fewer than three picks.
    """
    if len(picks) < LEAST_PICKS:
        raise ValueError(f"refine: {len(picks)} picks; allowed: {LEAST_PICKS} or more")
    started = time.perf_counter()
    reconstructor = reconstructor_of(problem.capture, JUDGE)
    best = Swapped(picks, 0.0, 0)
    for best in problem_swaps(reconstructor, problem, picks, np.random.default_rng(seed)):
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


def _key(picks: np.ndarray) -> tuple[int, ...]:
    return tuple(np.sort(picks).tolist())
