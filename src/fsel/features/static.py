"""The 14 features of a candidate that no pick changes (paper, Appendix A.1), and their table."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fsel.core.capture import Views
from fsel.core.files import Columns
from fsel.core.geometry import (
    directions,
    lengths,
    pairwise_angles,
    pairwise_distances,
    reference_points,
    viewing_angles,
)
from fsel.core.problem import Problem
from fsel.features.columns import FEATURES, STATIC

LOWER_IS_BETTER = (
    *("d_min_o", "d_mean_o", "d_p25_o", "gamma_min_o", "gamma_mean_o"),
    *("alpha_mean", "b_perp", "rho_max_s"),
)
SIGNS = {name: -1.0 if name in LOWER_IS_BETTER else 1.0 for name in FEATURES}
"""Sign of each feature in the untrained sum: distances to the targets and likeness to the selected
count against a frame, distances and angles to the selected for it (paper, Appendix D.3)."""

UNITS = {
    **dict.fromkeys(("d_min_o", "d_mean_o", "d_p25_o", "b_perp", "b_par"), "world"),
    **dict.fromkeys(("gamma_min_o", "gamma_mean_o", "alpha_mean"), "radian"),
    **dict.fromkeys(("rho_max_o", "rho_mean_o", "rho_std_o"), "cosine"),
    **{"tau_tri": "score in 0..1", "c_vis": "fraction", "sharpness": "squared grey level"},
}

FLAT = 1e-9  # a column whose deviation is below this share of its scale carries no information
MVSNET_ANGLE = 5.0  # degrees of the best triangulation angle (Yao et al. 2018)
MVSNET_SPREAD = (1.0, 10.0)


def static_features(
    problem: Problem, pool: np.ndarray, references: Views, appearance: bool = True
) -> np.ndarray:
    """Return (n, 14) features that do not depend on the selection, as `STATIC`, in `UNITS`.

    Args:
        problem: the selection problem.
        pool: (n,) frames to describe.
        references: views that stand for the targets: the proxies' poses in the paper, or the
            targets' own. Appearance is always compared with the proxies, the only ones with images.
        appearance: False leaves the three similarity columns zero and touches no descriptor.
    """
    capture = problem.capture
    centers, axes = capture.centers[pool], capture.axes[pool]
    distance = pairwise_distances(centers, references.centers)
    angle = pairwise_angles(axes, references.axes)
    columns = [
        distance.min(axis=1),
        distance.mean(axis=1),
        np.percentile(distance, 25, axis=1),
        angle.min(axis=1),
        angle.mean(axis=1),
        *(_likeness(problem, pool) if appearance else np.zeros((3, len(pool)))),
        *_relative_geometry(problem, pool, references),
        problem.sharpness[pool],
    ]
    return np.stack(columns, axis=1)


def _likeness(problem: Problem, pool: np.ndarray) -> list[np.ndarray]:
    """Columns rho_max_o, rho_mean_o, rho_std_o, (n,) each."""
    described = problem.descriptors.astype(np.float64)
    # einsum sums every row alike; a matrix product may part equal frames in the last bit
    likeness = np.einsum("nd,od->no", described[pool], described[problem.proxies])
    return [likeness.max(axis=1), likeness.mean(axis=1), likeness.std(axis=1)]


def _relative_geometry(problem: Problem, pool: np.ndarray, references: Views) -> list[np.ndarray]:
    """Columns tau_tri, alpha_mean, b_perp, b_par, c_vis, (n,) each."""
    capture = problem.capture
    centers = capture.centers[pool]
    points = proxy_points(problem, references)
    to_candidate = directions(centers[:, None], points[None])
    to_reference = directions(references.centers, points)
    triangulation = viewing_angles(to_candidate, to_reference[None])
    offset = centers[:, None] - references.centers[None]
    # MVSNet's view-selection score of a triangulation angle (Yao et al. 2018)
    degrees = np.degrees(triangulation)
    spread = np.where(degrees <= MVSNET_ANGLE, *MVSNET_SPREAD)
    score = np.exp(-((degrees - MVSNET_ANGLE) ** 2) / (2 * spread**2))
    along = np.einsum("noi,oi->no", offset, references.axes)
    across = lengths(offset - along[..., None] * references.axes[None])
    seen = viewing_angles(-to_candidate, capture.axes[pool][:, None])
    half_fov = capture.views.half_fov[pool]
    return [
        score.max(axis=1),
        triangulation.mean(axis=1),
        across.mean(axis=1),
        along.mean(axis=1),
        (seen <= half_fov[:, None]).mean(axis=1),
    ]


def proxy_points(problem: Problem, references: Views) -> np.ndarray:
    """Return (O, 3) one reference point a view, in front of it, near the candidates' centroid; of a
    request about an object, its centre for all."""
    if problem.focus is not None:
        return np.tile(problem.focus, (len(references), 1))
    centroid = problem.capture.centers[problem.candidates].mean(axis=0)
    return reference_points(references.centers, references.axes, centroid)


def features_table(problem: Problem) -> dict[str, Any]:
    """Describe every candidate, ascending, by what no pick changes (paper, section 3.2),
    unstandardised: frame, name, and the columns `STATIC` in `UNITS`."""
    names = [problem.capture.names[frame] for frame in problem.candidates]
    references = problem.capture.view(problem.proxies)
    values = static_features(problem, problem.candidates, references)
    return {"frame": problem.candidates, "name": names, **dict(zip(STATIC, values.T, strict=True))}


def with_features(problem: Problem, table: Columns, source: str | Path) -> Problem:
    """Return the problem with the features that `features_table` wrote down, rows in any order;
    ValueError for other candidates, or values that are missing or not finite."""
    order = np.argsort(table["frame"])
    frames = np.asarray(table["frame"])[order]
    if not np.array_equal(frames, problem.candidates):
        wrong = np.setxor1d(frames, problem.candidates)
        raise ValueError(
            f"{source}: {len(frames)} rows for {len(problem.candidates)} candidates (frames "
            f"{wrong[:5].tolist()} differ). Hint: it was made for another split; make it again"
        )
    # rows one after another, as they were computed: another order would sum in another order
    values = np.ascontiguousarray(np.array([table[name] for name in STATIC], np.float64).T[order])
    if not np.isfinite(values).all():
        row, column = np.argwhere(~np.isfinite(values))[0]
        value = values[row, column]
        raise ValueError(f"{source}: {STATIC[column]} of frame {frames[row]} is {value}")
    return replace(problem, features=values)
