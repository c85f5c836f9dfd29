"""Guarantees of cover: of frames by poses, for picks that no image is looked at for; of points.

Not in the paper. The rule alone may leave a long stretch of a capture without a pick. A traversal
to the farthest frame, again and again, leaves no frame farther from its first k frames than twice
what the best k frames would (Gonzalez 1985). So its first frames are picked until no frame is
farther than 1.5 times what all k of them would leave, and the rule picks the rest: no frame is
farther from the picks than three times what the best cover by as many frames reaches.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsel.selection.places import distances_to

SLACK = 1.5  # of the radius that the whole traversal reaches


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


def covering(places: np.ndarray, k: int) -> np.ndarray:
    """(m,) int64 rows, m <= k, that leave no row farther than 1.5 times what k of them would.

    Args:
        places: (n, 2, 3) see `fsel.selection.places.scene_places`.
        k: rows that a cover may have, 1 to n.
    """
    rows, radii = farthest_first(places, k)
    return rows[: int(np.argmax(radii <= SLACK * radii[-1])) + 1]


def farthest_first(places: np.ndarray, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Farthest-point traversal from the most central row; ties go to the lowest.

    Returns:
        (k,) int64 rows, and (k,) the largest distance of a row to the nearest of those so far.
    """
    rows, radii = np.empty(k, np.int64), np.empty(k)
    following = int(np.argmin(distances_to(places, places.mean(axis=0))))
    gap = np.full(len(places), np.inf)
    for i in range(k):
        rows[i] = following
        gap = np.minimum(gap, distances_to(places, places[following]))
        gap[following] = -1.0  # rows in one place are told apart
        following = int(np.argmax(gap))
        radii[i] = max(gap[following], 0.0)
    return rows, radii
