"""Simple selections for a capture, or for targets that are frames of it.

Not in the paper. Each is good on some captures and bad on others; `fsel.selection.halving` lets the
capture choose.
"""

from __future__ import annotations

import numpy as np

from fsel.core.geometry import pose_distance
from fsel.core.problem import Problem
from fsel.core.subsets import evenly
from fsel.selection.covisible import covisible
from fsel.selection.scene_depth import scene_distances
from fsel.selectors.baselines.by_pose import in_turn, nearest_frames
from fsel.selectors.baselines.kmedoids import fasterpam

EVEN = "uniform"  # uniform sampling, which the others are compared with
RULE = "fsel"
STEEP = 3  # power of the distance of the steep medoids: the farthest frames decide
LONGEST = 4.0  # of the median seconds between frames of a video: longer ones are pauses
SCALE = 1000.0  # of the largest distance: sums in float32 then keep what tells two swaps apart


def candidates(problem: Problem, k: int) -> dict[str, np.ndarray]:
    """A few selections of a whole capture by name, (k,) ascending frames of its `sequence` each.

    `uniform`: see `uniform`. `middles`: the middles of k equal stretches. `kmedoids`: the
    medoids of the frames' `scene_distances`. `steep_medoids`: those of the distances' third power.
    `paced_medoids`: the same where a step along the sequence counts as a typical step between
    neighbours. `covisibility`: see `fsel.selection.covisible`.
    """
    pool = problem.sequence
    n = len(pool)
    distance, order = scene_distances(problem.capture, pool), np.arange(n)
    pace = np.median(distance[order[:-1], order[1:]]) * np.abs(order[:, None] - order)
    rows = {
        EVEN: uniform(problem, k),
        "middles": stretches(n, k),
        "kmedoids": medoids(distance, k, 1),
        "steep_medoids": medoids(distance, k, STEEP),
        "paced_medoids": medoids(distance + pace, k, STEEP),
        "covisibility": covisible(problem, pool, k),
    }
    return {name: pool[found] for name, found in rows.items()}


def uniform(problem: Problem, k: int) -> np.ndarray:
    """(k,) ascending rows of the `sequence`, evenly spaced; of a video in time, as other tools
    take frames, but that pauses count little, and what is left out gives way to the nearest."""
    pool, seconds = problem.sequence, problem.seconds
    if seconds is None:
        return evenly(len(pool), k)
    steps = np.diff(seconds)
    usual = np.median(steps[steps > 0]) if (steps > 0).any() else 1.0
    steps = np.where(steps > 0, np.minimum(steps, LONGEST * usual), usual)  # from video to video
    clock = np.concatenate([[0.0], np.cumsum(steps)])
    return np.sort(in_turn(np.abs(clock[pool][:, None] - np.linspace(0, clock[-1], k)), k))


def serving(problem: Problem, rule: np.ndarray, targets: np.ndarray) -> dict[str, np.ndarray]:
    """A few selections by name, (k,) frames each, for targets, (F,) frames that are not picked.

    `nearest`: see `fsel.selectors.baselines.by_pose`. `nearest_in_depths`: the same by
    `scene_distances`. `half_nearest`: the first half of `nearest`, then the first of the rule's
    (k,) picks. `covisibility`: of what the targets see, see `fsel.selection.covisible`.
    """
    pool, k = problem.sequence, len(rule)
    frames = np.union1d(pool, targets)
    aimed = np.isin(frames, targets)
    depths = scene_distances(problem.capture, frames)[np.ix_(~aimed, aimed)]
    close = nearest_frames(problem, pool, k)
    first = close[: (k + 1) // 2]
    rest = rule[~np.isin(rule, first)][: k - len(first)]
    return {
        "nearest": close,
        "nearest_in_depths": pool[in_turn(depths, k)],
        "half_nearest": np.concatenate([first, rest]),
        "covisibility": frames[covisible(problem, frames, k, aimed)],
    }


def with_fixed(problem: Problem, frames: np.ndarray) -> np.ndarray:
    """Return (k,) frames with each fixed pick, in the place of the nearest that is none."""
    frames, fixed = frames.copy(), problem.fixed_picks
    centers, axes = problem.capture.centers, problem.capture.axes
    for pick in np.setdiff1d(fixed, frames):
        apart = pose_distance(centers[frames], axes[frames], centers[[pick]], axes[[pick]])[:, 0]
        frames[np.where(np.isin(frames, fixed), np.inf, apart).argmin()] = pick
    return frames


def stretches(count: int, k: int) -> np.ndarray:
    """(k,) int64 the middle row of each of k equal stretches of `count` rows."""
    return ((2 * np.arange(k) + 1) * count // (2 * k)).astype(np.int64)


def medoids(distance: np.ndarray, k: int, power: float) -> np.ndarray:
    """(k,) ascending rows, swapped one by one from evenly spaced ones until no swap lowers the sum
    over all rows of a power of the (n, n) distance to the nearest."""
    largest = distance.max()
    rows = (SCALE * (distance / (largest if largest > 0 else 1.0)) ** power).astype(np.float32)
    return np.sort(fasterpam(rows.__getitem__, len(rows), evenly(len(rows), k)))
