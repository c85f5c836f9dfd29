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
    """Return what picks k panoramas by their (N,) number, all views of each, the best one first.

    Where `ranked` takes account of frames picked before (`stepwise`), the next panorama is the one
    with the best next view; else one view stands for each.
    """

    def picked(problem: Problem, k: int) -> tuple[np.ndarray, np.ndarray]:
        pool, fixed = problem.observed, problem.fixed_picks
        firsts = fixed[np.unique(number[fixed], return_index=True)[1]].tolist()
        if not stepwise:
            one = np.sort(pool[np.unique(number[pool], return_index=True)[1]])
            firsts = ranked(replace(problem, candidates=one, proxies_free=False), k)[0].tolist()
        frames = fixed[:0]
        for step in range(k):
            if step == len(firsts):
                found, _ = ranked(replace(problem, fixed_picks=frames), len(frames) + 1)
                firsts.append(found[-1])
            views = pool[number[pool] == number[firsts[step]]]
            frames = np.concatenate([frames, [firsts[step]], views[views != firsts[step]]])
        return frames, np.full(len(frames), np.nan)

    return picked
