"""Cover of the sparse points by the picks: every point is seen so often."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fsel.core.problem import Problem
from fsel.core.subsets import evenly
from fsel.core.wording import counted

if TYPE_CHECKING:
    from fsel.selectors.baselines.covisibility import Tracks


@dataclass(frozen=True)
class Cover:
    """A cover of the sparse points, see `fsel.selection.multicover`.

    Attributes:
        times: how often each point is to be seen.
        share: of the points that is to be seen so often.
        frames: how many frames it took.
        points: that so many frames or more see.
        picks: (times + 1,) how many of them the picks see 0, 1, ..., `times` times or more.
        even: the same of as many frames evenly spaced.
    """

    times: int
    share: float
    frames: int
    points: int
    picks: tuple[int, ...]
    even: tuple[int, ...]


def seeing_all(problem: Problem, k: int | None, times: int, share: float) -> Problem:
    """The same with frames that are picked first, so that a share of the points is seen so often.

    Raises:
        ValueError: for a capture without points that so many frames see, or more frames needed
            than k.
    """
    from fsel.selection.multicover import multicover  # here: numba takes long to import

    given = problem.observed[multicover(_tracks(problem, times), times, share)]
    if isinstance(k, int) and k < len(given):
        often = sighted(problem, times)(given[:k])
        reached = often[-1] / sum(often)
        fits = np.floor(100 * reached) / 100
        share_of = f", or a cover_share, --cover-share, of {fits:.2f}" if fits else ""
        raise ValueError(
            f"k is {k}, and a cover of {times} takes {counted(len(given), 'frame')}; {k} see "
            f"{reached:.1%} of the points so often. Hint: k of {len(given)}{share_of}"
        )
    return replace(problem, fixed_picks=given)


def cover_of(problem: Problem, picks: np.ndarray, times: int, share: float) -> Cover:
    """Say how often the picks see the points, and as many frames evenly spaced."""
    often = sighted(problem, times)
    found, frames = often(picks), len(problem.fixed_picks)
    even = often(problem.observed[evenly(len(problem.observed), len(picks))])
    return Cover(times, share, frames, points=sum(found), picks=found, even=even)


def sighted(problem: Problem, times: int) -> Callable[[np.ndarray], tuple[int, ...]]:
    """Make what counts the points that frames see 0, 1, ..., `times` times or more, of those that
    so many see.

    Raises:
        ValueError: for a capture without such points.
    """
    from fsel.selection.multicover import sightings, wanted

    seen, pool = _tracks(problem, times), problem.observed
    counted_points = wanted(seen, times)

    def often(frames: np.ndarray) -> tuple[int, ...]:
        seeing = sightings(seen, np.searchsorted(pool, frames))[counted_points]
        return tuple(np.bincount(np.minimum(seeing, times), minlength=times + 1).tolist())

    return often


def _tracks(problem: Problem, times: int) -> Tracks:
    from fsel.selection.multicover import wanted
    from fsel.selectors.baselines.covisibility import tracks

    points = problem.capture.points
    if points is None or not len(points.track_point):
        raise ValueError(
            f"{problem.capture.source}: has no sparse points with observations, which a "
            "cover needs. Hint: fsel poses, or --poses colmap"
        )
    seen = tracks(problem, problem.observed)
    if not wanted(seen, times).any():
        raise ValueError(
            f"cover is {times}, and no point of {problem.capture.source} is seen by so many of "
            f"{counted(len(problem.observed), 'frame')} that may be selected"
        )
    return seen
