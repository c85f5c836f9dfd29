"""Views of panoramas: those of one moment are one candidate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fsel.core.capture import Capture
from fsel.core.geometry import distances_from_middle, lengths
from fsel.core.problem import Problem
from fsel.selectors.policies import Ranked

SAME = 1e-6  # of the cameras' spread, within which two are in one place


def panorama_of(capture: Capture) -> np.ndarray | None:
    """Return (N,) numbers of the panoramas that frames are views of; None where they are of none.

    Views of one panorama lie in one place, and are named alike in folders of their own.
    """
    names = [name.partition("/")[2] for name in capture.names]
    _, first, number = np.unique(names, return_index=True, return_inverse=True)
    if "" in names or 2 * len(first) > len(names):
        return None
    apart = lengths(capture.centers - capture.centers[first[number]]).max()
    return number if apart <= SAME * distances_from_middle(capture.centers)[1] else None


def by_panorama(ranked: Ranked, number: np.ndarray, *, stepwise: bool) -> Ranked:
    """Return what picks k panoramas, all views of each, the view that was picked for first.

    Args:
        ranked: picks single frames.
        number: (N,) the panorama of each frame.
        stepwise: whether it takes account of `Problem.fixed_picks`; then the next panorama is the
            one with the best next view, else one view stands for each.
    """

    def views(pool: np.ndarray, frame: int) -> np.ndarray:
        alike = pool[number[pool] == number[frame]]
        return np.concatenate([[frame], alike[alike != frame]])

    def picked(problem: Problem, k: int) -> tuple[np.ndarray, np.ndarray]:
        pool, scores = problem.observed, np.empty(0)
        if not stepwise:
            _, first = np.unique(number[pool], return_index=True)
            few = replace(problem, candidates=np.sort(pool[first]), proxies_free=False)
            frames = np.concatenate([views(pool, frame) for frame in ranked(few, k)[0]])
            return frames, np.full(len(frames), np.nan)
        firsts = problem.fixed_picks[np.unique(number[problem.fixed_picks], return_index=True)[1]]
        frames = np.concatenate([problem.fixed_picks[:0], *(views(pool, one) for one in firsts)])
        while len(np.unique(number[frames])) < k:
            found, scores = ranked(replace(problem, fixed_picks=frames), len(frames) + 1)
            frames = np.concatenate([frames, views(pool, found[-1])])
        return frames, np.concatenate([scores, np.full(len(frames) - len(scores), np.nan)])

    return picked
