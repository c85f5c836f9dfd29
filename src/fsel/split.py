"""Targets H, proxies O, candidates P (paper, section 3.1 and Appendix A.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from fsel.capture import Capture
from fsel.geometry import pose_distance

COVERAGES = (25, 40, 60, 80, 100)
EVALUATION_TARGETS = 15
_EVALUATION, _COVERAGE = 1, 2  # apart, so that equal numbers never share a random stream


@dataclass(frozen=True)
class Split:
    """A partition of a capture's frames.

    Attributes:
        targets: (H,) int64 held-out frames, ascending.
        proxies: (H,) int64 observed stand-ins; `proxies[i]` belongs to `targets[i]`.
        candidates: (P,) int64 every other frame, ascending.
        region: (R,) int64 the candidates inside the region that targets were drawn from,
            ascending; all candidates where targets were drawn over the whole capture.
    """

    targets: np.ndarray
    proxies: np.ndarray
    candidates: np.ndarray
    region: np.ndarray


def evaluation_split(
    capture: Capture, draw: int, seed: int, targets: int = EVALUATION_TARGETS
) -> Split:
    """Targets drawn uniformly over the whole capture.

    Args:
        capture: at least 2 * targets + 1 frames.
        draw: number of the draw; each is an independent stream of the same seed.
        seed: of the experiment.
        targets: how many target views.

    Raises:
        ValueError: when the capture has too few frames.
    """
    rng = np.random.default_rng([_EVALUATION, seed, draw])
    return _split(capture, np.arange(len(capture)), targets, rng)


def coverage_split(capture: Capture, coverage: int, seed: int) -> Split:
    """Targets drawn from the region around a random anchor camera, as for training labels.

    The region is the `coverage` percent of frames whose centres are nearest to the anchor, itself
    included; it holds max(4, round(0.15 coverage)) targets: 4, 6, 9, 12 and 15 at the paper's
    five levels. Proxies and candidates may lie outside of it.

    Args:
        capture: enough frames for the targets, as many proxies, and a candidate.
        coverage: 25, 40, 60, 80 or 100 percent.
        seed: of the anchor and of the targets.

    Raises:
        ValueError: for another coverage, or when the capture or the region has too few frames.
    """
    if coverage not in COVERAGES:
        raise ValueError(f"coverage must be one of {COVERAGES} percent, got {coverage}")
    rng = np.random.default_rng([_COVERAGE, seed, coverage])
    anchor = capture.centers[rng.integers(len(capture))]
    nearest = np.argsort(np.linalg.norm(capture.centers - anchor, axis=1), kind="stable")
    size = _round_half_up(coverage / 100 * len(capture))
    targets = max(4, _round_half_up(0.15 * coverage))
    return _split(capture, np.sort(nearest[:size]), targets, rng)


def _split(capture: Capture, region: np.ndarray, count: int, rng: np.random.Generator) -> Split:
    if count < 1 or len(capture) < 2 * count + 1 or len(region) < count:
        raise ValueError(
            f"{capture.source or 'capture'}: {len(capture)} frames, {len(region)} of them in the "
            f"region of the targets, are too few for {count} targets, {count} proxies and a "
            f"candidate: at least {2 * count + 1} frames and {count} in the region are needed; "
            "record more frames or ask for fewer targets"
        )
    targets = np.sort(rng.choice(region, size=count, replace=False))
    remaining = np.setdiff1d(np.arange(len(capture)), targets)
    proxies = remaining[match_proxies(capture, targets, remaining)]
    candidates = np.setdiff1d(remaining, proxies)
    return Split(targets, proxies, candidates, np.intersect1d(candidates, region))


def match_proxies(capture: Capture, targets: np.ndarray, remaining: np.ndarray) -> np.ndarray:
    """One distinct frame a target, with the smallest summed pose distance.

    Args:
        capture: the posed sequence.
        targets: (H,) frames.
        remaining: (R,) frames to match with, R >= H.

    Returns:
        (H,) int64 positions in `remaining`, in the targets' order.
    """
    centers, axes = capture.centers, capture.axes
    cost = pose_distance(centers[targets], axes[targets], centers[remaining], axes[remaining])
    return linear_sum_assignment(cost)[1]


def _round_half_up(value: float) -> int:
    return math.floor(value + 0.5)
