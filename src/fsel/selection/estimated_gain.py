"""Estimated gain of picks on targets whose images nobody has, from observed frames near them.

Not in the paper. Observed frames near the targets are the validation frames: one is rendered and
scored while it is not picked, so that no frame is scored on itself. Their PSNR alone misleads: a
pick beside a validation frame raises it, wherever the target is, and the frame nearest to a target
is scored no more once it is picked. So what poses alone explain is subtracted from the gain on the
validation frames, and what they explain of the gain on the targets is added.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsel.core.geometry import pairwise_angles, pairwise_distances, pose_distance
from fsel.core.problem import Problem
from fsel.metrics import score_views
from fsel.reconstruct import Model, Reconstructor

VALIDATION = 7  # frames nearest to each target, on which picks are scored
SLOPE = 7.0  # dB that a view gains where its closeness grows e-fold, on 24 training scenes
REST = 0.1  # added to the distance, so that no pick counts more than 10
FIRST = 0.3  # of the validation frames, those that a swap concerns most: rendered first
METRIC = ("psnr",)


@dataclass(frozen=True)
class Closeness:
    """Closeness of picks to V views: the sum over picks of 1 / (distance + 0.1).

    The distance is that of the centres plus the angle between the axes, each over its `largest`.

    Attributes:
        centers, axes: (V, 3) float64 camera centres and optical axes of the views.
        frames: (V,) int64 the frame that a view is of, which does not count there; -1 for none.
        all_centers, all_axes: (N, 3) of all frames.
        largest: the distance of centres, and the angle in radians, that count as one.
    """

    centers: np.ndarray
    axes: np.ndarray
    frames: np.ndarray
    all_centers: np.ndarray
    all_axes: np.ndarray
    largest: tuple[float, float]

    @classmethod
    def of(cls, problem: Problem, frames: np.ndarray) -> Closeness:
        """The views are (J,) frames, then the T targets."""
        capture, targets, pool = problem.capture, problem.targets, problem.observed
        far = pairwise_distances(targets.centers, capture.centers[pool]).max()
        turned = pairwise_angles(targets.axes, capture.axes[pool]).max()
        return cls(
            np.concatenate([capture.centers[frames], targets.centers]),
            np.concatenate([capture.axes[frames], targets.axes]),
            np.concatenate([frames, np.full(len(targets), -1)]),
            capture.centers,
            capture.axes,
            (far or 1.0, turned or 1.0),
        )

    def __call__(self, picks: np.ndarray) -> np.ndarray:
        """(V,) float64 without unit, of (K,) picks."""
        distance = pairwise_distances(self.centers, self.all_centers[picks]) / self.largest[0]
        distance += pairwise_angles(self.axes, self.all_axes[picks]) / self.largest[1]
        own = self.frames[:, None] == picks
        return np.where(own, 0.0, 1 / (distance + REST)).sum(axis=1)


@dataclass
class Estimated:
    """Picks that were scored on all validation frames.

    Attributes:
        picks: (K,) int64.
        gain: dB.
        psnr: (J,) float64 of the validation frames; NaN for picks.
    """

    picks: np.ndarray
    gain: float
    psnr: np.ndarray


class EstimatedGain:
    """Mean gain in PSNR on a problem's targets over some first picks, estimated.

    Args:
        reconstructor: bound to the problem's capture, at the reconstruction size.
        problem: targets, by their poses alone, and observed frames.
        picks: (K,) the first picks, K >= 3.

    Attributes:
        nearest: see `nearest_to_targets`.
        frames: (J,) int64 the validation frames, ascending.
        base: (J,) PSNR of each by the first picks without itself. Without it, subsets that hold the
            frames that are hard to render would look better than they are.
        best: the best picks so far.
    """

    def __init__(self, reconstructor: Reconstructor, problem: Problem, picks: np.ndarray) -> None:
        self.nearest = nearest_to_targets(problem)
        near = self.nearest[:, :VALIDATION]
        self.frames = np.unique(near)
        self._of_targets = np.searchsorted(self.frames, near)
        self._reconstructor = reconstructor
        self._images = np.asarray(reconstructor.capture.images[self.frames])
        self._closeness = Closeness.of(problem, self.frames)
        self._before = self._closeness(picks)
        free = ~np.isin(self.frames, picks)
        start = self._scores(picks, free)
        self.base = start.copy()
        for row in np.flatnonzero(~free):
            alone = np.arange(len(free)) == row
            self.base[row] = self._scores(np.setdiff1d(picks, self.frames[row]), alone)[row]
        self.best = Estimated(picks, 0.0, start)

    def __call__(self, picks: np.ndarray) -> float:
        """Gain in dB of (K,) distinct picks, in any order.

        The frames that a swap concerns most are rendered first. Where the gain with them is not
        above the best so far, it is returned as it is.
        """
        model = self._reconstructor.fit(np.sort(picks))
        psnr, closeness = np.full(len(self.frames), np.nan), self._closeness(picks)
        first, rest = self._parted(picks, closeness)
        psnr[first] = self._rendered(model, first)
        psnr[rest] = self.best.psnr[rest]
        gain = self._gain(psnr, closeness)
        if gain > self.best.gain:
            psnr[rest] = self._rendered(model, rest)
            gain = self._gain(psnr, closeness)
        if gain > self.best.gain:
            self.best = Estimated(picks, gain, psnr)
        return gain

    def _parted(self, picks: np.ndarray, closeness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows of the frames not picked, in two: those that swaps from the best concern most."""
        free = np.flatnonzero(~np.isin(self.frames, picks))
        changed = np.setxor1d(picks, self.best.picks)
        share = self._closeness(changed)[free] / closeness[free]
        share[np.isnan(self.best.psnr[free])] = np.inf  # these were picked: nothing is known
        ordered = free[np.argsort(-share, kind="stable")]
        count = max(int(np.ceil(FIRST * len(free))), np.count_nonzero(np.isinf(share)))
        return ordered[:count], ordered[count:]

    def _gain(self, psnr: np.ndarray, closeness: np.ndarray) -> float:
        """Estimate the gain from (J,) PSNR, NaN where a frame is picked, and (J + T,) closeness."""
        explained = SLOPE * np.log(closeness / self._before)
        count = len(self.frames)
        beyond = psnr - self.base - explained[:count]
        scored = ~np.isnan(beyond)[self._of_targets]
        sums = np.where(scored, beyond[self._of_targets], 0.0).sum(axis=1)
        served = scored.any(axis=1)
        means = sums[served] / scored.sum(axis=1)[served]
        return float(explained[count:].mean() + (means.mean() if len(means) else 0.0))

    def _scores(self, picks: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """(J,) PSNR by picks of some of the frames, (J,) bool; NaN for the others."""
        psnr = np.full(len(self.frames), np.nan)
        model = self._reconstructor.fit(np.sort(picks))
        psnr[rows] = self._rendered(model, np.flatnonzero(rows))
        return psnr

    def _rendered(self, model: Model, rows: np.ndarray) -> np.ndarray:
        """PSNR of some rows of the frames."""
        if len(rows) == 0:
            return np.empty(0)
        rendered = model.render(self._reconstructor.capture.view(self.frames[rows]))
        return score_views(rendered, self._images[rows], metrics=METRIC)[:, 0]


def nearest_to_targets(problem: Problem) -> np.ndarray:
    """(T, P) observed frames, a row a target, the nearest first."""
    capture, pool, targets = problem.capture, problem.observed, problem.targets
    distance = pose_distance(
        targets.centers, targets.axes, capture.centers[pool], capture.axes[pool]
    )
    return pool[np.argsort(distance, axis=1, kind="stable")]
