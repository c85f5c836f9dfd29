"""What the frames of a pool are to the targets and to one another, before any is picked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsel.features.conditioned import TURN
from fsel.features.static import mvsnet_score, static_features
from fsel.geometry import (
    directions,
    pairwise_angles,
    pairwise_distances,
    viewing_angles,
)
from fsel.problem import Problem
from fsel.selector.greedy import Prepared, standardise
from fsel.selector.policies import POLICIES

RULE = POLICIES["fsel"]
EQUALS = 6  # frames nearest by look distance that a frame's sharpness is compared with


@dataclass(frozen=True)
class Pairs:
    """The n frames of a problem's observed pool; lengths are over the scene's depth.

    The matrices are for pools of some hundred frames, as those of experiments.

    Attributes:
        prepared: of the policy `fsel`: the rows of everything below.
        static: (n, 14) the paper's features that no pick changes, in relation to the targets'
            poses, standardised.
        distance: (n, n) between camera centres.
        angle, bearing: (n, n) between optical axes, and between directions from the targets'
            common reference point, radians.
        likeness: (n, n) cosines of the descriptors.
        parallax: (n, n) angle at the point that frame i looks at, between i and j, radians.
        support: (n, n) MVSNet's score of that angle where j sees the point, else 0.
        sharper: (n,) logarithm of a frame's sharpness over the median of its nearest frames'.
    """

    prepared: Prepared
    static: np.ndarray
    distance: np.ndarray
    angle: np.ndarray
    bearing: np.ndarray
    likeness: np.ndarray
    parallax: np.ndarray
    support: np.ndarray
    sharper: np.ndarray

    @classmethod
    def of(cls, problem: Problem) -> Pairs:
        """The pairs of a problem's observed frames."""
        prepared = RULE.prepare(problem)
        pool, rows = prepared.pool, prepared.rows
        here, ahead = rows.looks[:, :3], rows.looks[:, 3:] / TURN
        described = problem.descriptors[pool].astype(np.float64)
        to_point = directions(ahead[:, None], here[None])
        parallax = viewing_angles(to_point, directions(ahead, here)[:, None])
        off_axis = viewing_angles(to_point, rows.axes[None])
        sees = off_axis <= problem.capture.views.half_fov[pool]
        shift, turn = pairwise_distances(here, here), pairwise_distances(ahead, ahead)
        return cls(
            prepared=prepared,
            static=standardise(static_features(problem, pool, problem.targets)),
            distance=shift,
            angle=pairwise_angles(rows.axes, rows.axes),
            bearing=pairwise_angles(rows.bearings, rows.bearings),
            likeness=np.einsum("nd,md->nm", described, described),
            parallax=parallax,
            support=np.where(sees, mvsnet_score(parallax), 0.0),
            sharper=_sharper(problem.sharpness[pool], shift + TURN * turn),
        )


def _sharper(sharpness: np.ndarray, apart: np.ndarray) -> np.ndarray:
    nearest = np.argsort(apart, axis=1, kind="stable")[:, 1 : EQUALS + 1]
    level = np.log1p(sharpness)
    return level - np.median(level[nearest], axis=1)
