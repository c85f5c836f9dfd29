"""The part of a capture that is farthest from all picks, in what is seen and not in time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fsel.captures.quality.findings import MISPLACED
from fsel.core.subsets import evenly
from fsel.selection.outcome import Outcome
from fsel.selection.scene_depth import image_shift, viewing_distance
from fsel.selection.targets import ALL

WIDE = 3.0  # times the usual gap, from which the output warns
MOST = 3000  # frames that are looked at, evenly spread
LEAST = 3  # picks that tell what is usual


class Gap(NamedTuple):
    """The largest gap between picks: the frame in it that is farthest from all of them."""

    frame: int
    name: str
    shift: float  # to the nearest pick: turn and parallax, in fields of view
    usual: float  # the median over the picks of that of the farthest frame around each

    @property
    def wide(self) -> bool:
        """Check whether it is so much larger than usual that a part of the scene may be missing."""
        return self.shift > WIDE * self.usual

    def __str__(self) -> str:
        return (
            f"the picks leave a gap: {self.name} lies {self.shift:.2f} fields of view from the "
            f"nearest pick, {self.usual:.2f} is usual. Hint: --always {self.name} picks it; where "
            "all frames there are bad, film that part again"
        )


def gap_of(outcome: Outcome) -> Gap | None:
    """Return the largest gap between the picks; None of few, and where targets are stated."""
    capture, picks = outcome.capture, outcome.selection.indices
    if outcome.targets.kind != ALL or len(picks) < LEAST:
        return None
    frames = evenly(len(capture), MOST)
    if outcome.health is not None:
        frames = np.setdiff1d(frames, outcome.health.of_kind(MISPLACED))
    depth = float(np.median(viewing_distance(capture.views, capture.points)))
    shift = image_shift(capture.view(picks), capture.view(frames), depth)
    around, nearest = np.zeros(len(picks)), shift.min(axis=0)
    np.maximum.at(around, shift.argmin(axis=0), nearest)
    at = int(np.argmax(nearest))
    frame = int(frames[at])
    return Gap(frame, capture.names[frame], float(nearest[at]), float(np.median(around)))
