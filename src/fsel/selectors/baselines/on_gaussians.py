"""FisherRF and COVER on small trained Gaussians, in place of splats."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.special import expit

from fsel.core.capture import Capture, Views
from fsel.core.problem import Problem
from fsel.reconstruct.gaussians import Gaussians
from fsel.reconstruct.gaussians.table import LOGIT
from fsel.selectors.baselines import cover, fisher_rf
from fsel.selectors.baselines.splat_views import FAINT, Blends, greedy_on_splats, scaled

LONG_SIDE = 64  # pixels
SETTINGS = {"steps": 150, "gaussians": 2000, "background": "mean"}


def by_gaussians(capture: Capture, pool: np.ndarray, rows: np.ndarray) -> Blends:
    """Train `gaussians`; a `Fitting`."""
    picked = capture.subset(pool[rows]).resized(LONG_SIDE)
    model = Gaussians(picked, **SETTINGS).fit(np.arange(len(rows)))
    splats = np.vstack([model.positions.T, expit(model.table[:, LOGIT])]).astype(np.float32)
    poses, intrinsics = capture.world_to_camera[pool], scaled(capture, pool, picked)
    parts, covered = [], []
    for canvas in model.drawings(Views(poses, intrinsics, picked.size)):
        weight, square = canvas.weights().T
        kept = weight > FAINT
        parts.append((canvas.source[kept], weight[kept], square[kept]))
        covered.append(np.count_nonzero(canvas.rest < 1))
    start = np.cumsum([0, *(len(index) for index, _, _ in parts)])
    index, weight, square = (np.concatenate(part) for part in zip(*parts, strict=True))
    poses, intrinsics = poses.astype(np.float32), intrinsics.astype(np.float32)
    filled = start, index, weight, square, np.array(covered)
    return Blends(splats, poses, intrinsics, picked.size, *filled)


def by_information(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick by `fsel.selectors.baselines.fisher_rf.Information`."""
    return greedy_on_splats(problem, k, fisher_rf.Information, by_gaussians)


def by_coverage(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick by `fsel.selectors.baselines.cover.Coverage`."""
    return greedy_on_splats(problem, k, cover.Coverage, by_gaussians)


FISHER_RF = replace(
    fisher_rf.METHOD,
    name="fisher_rf_gaussians",
    label="FisherRF, gaussians",
    select=by_information,
)
COVER = replace(cover.METHOD, name="cover_gaussians", label="COVER, gaussians", select=by_coverage)
