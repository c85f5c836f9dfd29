"""The scorer's inputs that do not follow the selection (paper, section 3.2 and Appendix A.1).

Raw features are in world units and radians; z-scores remove the scale. The four columns that
follow the selection, and the optional nineteenth input, live in `fsel.selector`.
"""

from __future__ import annotations

import numpy as np

from fsel.geometry import (
    directions,
    paired_angles,
    pairwise_distances,
    reference_points,
    viewing_angles,
)
from fsel.problem import Problem

STATIC = (
    "d_min_o",
    "d_mean_o",
    "d_p25_o",
    "gamma_min_o",
    "gamma_mean_o",
    "rho_max_o",
    "rho_mean_o",
    "rho_std_o",
    "tau_tri",
    "alpha_mean",
    "b_perp",
    "b_par",
    "c_vis",
    "sharpness",
)
CONDITIONED = ("d_min_s", "gamma_min_s", "rho_max_s", "phi_nov")
# The order of the scorer's first 18 inputs, and of the paper's Table "Tested features": 13 static
# relations, 4 conditioned ones, sharpness. The nineteenth input is `gain`, or zero.
FEATURES = (*STATIC[:-1], *CONDITIONED, STATIC[-1])
APPEARANCE = ("rho_max_o", "rho_mean_o", "rho_std_o", "rho_max_s")
# +1 where a higher value should help, -1 where a lower one should: the untrained control's signs.
SIGNS = {
    "d_min_o": -1,
    "d_mean_o": -1,
    "d_p25_o": -1,
    "gamma_min_o": -1,
    "gamma_mean_o": -1,
    "rho_max_o": 1,
    "rho_mean_o": 1,
    "rho_std_o": 1,
    "tau_tri": 1,
    "alpha_mean": -1,
    "b_perp": -1,
    "b_par": 1,
    "c_vis": 1,
    "d_min_s": 1,
    "gamma_min_s": 1,
    "rho_max_s": -1,
    "phi_nov": 1,
    "sharpness": 1,
}

FLAT = 1e-9  # a column whose deviation is below this share of its largest value carries nothing
MVSNET_ANGLE, MVSNET_BELOW, MVSNET_ABOVE = 5.0, 1.0, 10.0  # degrees (Yao et al. 2018)
REFERENCES = ("proxies", "targets")


def reference_poses(problem: Problem, reference: str) -> tuple[np.ndarray, np.ndarray]:
    """(O, 3) centres and (O, 3) unit axes that geometric features compare candidates with.

    Args:
        problem: the selection problem.
        reference: `proxies`, as in the paper, or `targets`, the requested poses themselves.

    Raises:
        ValueError: for another reference.
    """
    if reference not in REFERENCES:
        raise ValueError(f"reference must be one of {REFERENCES}, got {reference!r}")
    if reference == "targets":
        return problem.targets.centers, problem.targets.axes
    return problem.capture.centers[problem.proxies], problem.capture.axes[problem.proxies]


def scene_points(problem: Problem, pool: str, reference: str) -> np.ndarray:
    """(O, 3) reference points; the rows of the pool define the centroid (Appendix A.1)."""
    centroid = problem.capture.centers[problem.pool(pool)].mean(axis=0)
    return reference_points(*reference_poses(problem, reference), centroid)


def static_features(
    problem: Problem,
    pool: str = "candidates",
    reference: str = "proxies",
    appearance: bool = True,
) -> np.ndarray:
    """Raw features of the pool's frames against the reference views.

    Appearance always compares with the proxies: a target has no image. In a pool that holds the
    proxies, a proxy is compared with itself like with any other.

    Args:
        problem: the selection problem.
        pool: `candidates` (P) or `observed` (P and O): which frames are rows.
        reference: `proxies` or `targets`: what the geometric columns compare with.
        appearance: False leaves the three similarity columns zero and touches no descriptor.

    Returns:
        (n, 14) float64, columns as `STATIC`; rows in the order of `problem.pool(pool)`.

    Raises:
        ValueError: for another reference.
    """
    frames = problem.pool(pool)
    centers, axes = problem.capture.centers[frames], problem.capture.axes[frames]
    poses = reference_poses(problem, reference)
    points = scene_points(problem, pool, reference)
    cones = problem.capture.view(frames).half_fov
    return np.column_stack(
        [
            _closeness(centers, axes, *poses),
            _similarity(problem, frames) if appearance else np.zeros((len(frames), 3)),
            _parallax(centers, poses[0], points),
            _offsets(centers, *poses),
            _visible(centers, axes, cones, points),
            problem.sharpness[frames],
        ]
    )


def _closeness(centers, axes, view_centers, view_axes) -> np.ndarray:
    """(n, 5) d_min, d_mean, d_25, gamma_min, gamma_mean."""
    distance = pairwise_distances(centers, view_centers)
    angle = viewing_angles(axes, view_axes)
    return np.column_stack(
        [
            distance.min(axis=1),
            distance.mean(axis=1),
            np.percentile(distance, 25, axis=1),
            angle.min(axis=1),
            angle.mean(axis=1),
        ]
    )


def _similarity(problem: Problem, frames: np.ndarray) -> np.ndarray:
    """(n, 3) rho_max, rho_mean, sigma_rho."""
    every = problem.descriptors
    # einsum sums each row alike; a BLAS product would part equal frames in their last bit.
    rho = np.stack(
        [np.einsum("nd,d->n", every[frames], every[o], dtype=np.float64) for o in problem.proxies],
        axis=1,
    )
    return np.column_stack([rho.max(axis=1), rho.mean(axis=1), rho.std(axis=1)])


def _parallax(centers, view_centers, points) -> np.ndarray:
    """(n, 2) tau_tri, alpha_mean: the triangulation angle at each view's reference point.

    The angle is 0 where the candidate or the view's own camera stands on the point.
    """
    to_candidate = centers[:, None] - points
    to_view = view_centers - points
    scale = max(np.linalg.norm(to_candidate, axis=-1).max(), np.finfo(np.float64).tiny)
    angle = paired_angles(directions(to_candidate, scale), directions(to_view, scale)[None])
    return np.column_stack([mvsnet_score(angle).max(axis=1), angle.mean(axis=1)])


def mvsnet_score(angle: np.ndarray) -> np.ndarray:
    """MVSNet's view-selection score of triangulation angles in radians (Yao et al. 2018).

    A Gaussian about 5 degrees, of deviation 1 degree below and 10 above.
    """
    off = np.degrees(angle) - MVSNET_ANGLE
    return np.exp(-0.5 * (off / np.where(off <= 0, MVSNET_BELOW, MVSNET_ABOVE)) ** 2)


def _offsets(centers, view_centers, view_axes) -> np.ndarray:
    """(n, 2) b_perp, the mean distance to each full viewing line, and b_par, the signed mean."""
    offset = centers[:, None] - view_centers
    along = np.einsum("noi,oi->no", offset, view_axes)
    across = np.linalg.norm(offset - along[..., None] * view_axes, axis=-1)
    return np.column_stack([across.mean(axis=1), along.mean(axis=1)])


def _visible(centers, axes, cones, points) -> np.ndarray:
    """(n,) c_vis: share of the reference points within the candidate's viewing cone.

    A point at the camera's own centre counts as seen.
    """
    to_point = points - centers[:, None]
    scale = max(np.linalg.norm(to_point, axis=-1).max(), np.finfo(np.float64).tiny)
    angle = paired_angles(axes[:, None], directions(to_point, scale))
    return (angle <= cones[:, None]).mean(axis=1)


def standardise(columns: np.ndarray) -> np.ndarray:
    """Z-scores over the rows, with the population deviation.

    Args:
        columns: (n, c) float64.

    Returns:
        (n, c) float64; a column whose deviation is at most 1e-9 of its largest absolute value
        is zero.
    """
    deviation = columns.std(axis=0)
    flat = deviation <= FLAT * np.abs(columns).max(axis=0)
    return np.where(flat, 0.0, (columns - columns.mean(axis=0)) / np.where(flat, 1.0, deviation))
