"""Angles, distances and reference points; float64, nothing that knows about files."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

ROUNDING = 2.0**-46  # of the largest coordinate: what turning and shifting poses may leave behind
OPENGL_TO_OPENCV = np.diag([1.0, -1.0, -1.0])  # camera axes; its own inverse
SAME_AXIS = 4 * ROUNDING  # unit vectors closer than this are one
ROTATION_TOLERANCE = 1e-6
PRINTED = 1e-3  # what few digits of a rotation may have cost it
LEAST_LENGTH, MOST_LENGTH = 1e-60, 1e60  # of the longest translation, world units
LEVEL = 0.02  # mean square of the sine by which horizontal axes may leave the horizon


def merged(points: np.ndarray) -> np.ndarray:
    """Return (n, 3) points with coordinates made equal that only rounding tells apart, which
    standardising would blow up."""
    out = points.copy()
    limit = ROUNDING * np.abs(points).max(initial=0.0)
    for column in out.T:
        order = np.argsort(column, kind="stable")
        ordered = column[order]
        first = np.diff(ordered, prepend=-np.inf) > limit
        column[order] = ordered[first][np.cumsum(first) - 1]
    return out


def centered(points: np.ndarray) -> np.ndarray:
    """Return (n, d) points less their mean: exactly zero where all are equal."""
    offset = points - points[0]
    return offset - offset.mean(axis=0)


def distances_from_middle(centers: np.ndarray) -> tuple[np.ndarray, float]:
    """Return (N,) distances of (N, 3) centres from their median, and their 95th percentile, or the
    largest where that is zero."""
    distance = np.linalg.norm(centers - np.median(centers, axis=0), axis=1)
    return distance, float(np.percentile(distance, 95) or distance.max())


def camera_centers(world_to_camera: np.ndarray) -> np.ndarray:
    """Return (N, 3) centres, in world units, of (N, 3, 4) poses; of the same dtype."""
    return -np.einsum("nij,ni->nj", world_to_camera[:, :, :3], world_to_camera[:, :, 3])


def pose_matrices(rotations: np.ndarray, translations: np.ndarray) -> np.ndarray:
    """Return (N, 3, 4) world-to-camera of (N, 3, 3) rotations and (N, 3) translations."""
    return np.concatenate([rotations, translations[..., None]], axis=2)


def poses_at(centers: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Return (N, 3, 4) world-to-camera of cameras at (N, 3) centres with (N, 3, 3) rotations."""
    return pose_matrices(rotations, -np.einsum("nij,nj->ni", rotations, centers))


def upwards(world_to_camera: np.ndarray) -> np.ndarray:
    """Return the (3,) unit upward direction of (N, 3, 4) poses: across the horizontal axes.

    By least squares; where these leave a choice, as on a straight track, the mean of the images'
    upward axes decides, and where it cancels out, -y.
    """
    mean = -world_to_camera[:, 1, :3].mean(axis=0)
    right = world_to_camera[:, 0, :3]
    spread, directions = np.linalg.eigh(right.T @ right / len(right))
    across = directions[:, spread <= spread[0] + LEVEL]
    for guess in (mean, np.array([0.0, -1.0, 0.0])):
        up = across @ (across.T @ guess)
        if np.linalg.norm(up) > 1e-6:
            return up / np.linalg.norm(up)
    return across[:, 0]


def upright(world_to_camera: np.ndarray) -> np.ndarray:
    """Return the (3, 3) smallest rotation of a world after which z points upwards."""
    x, y, z = upwards(world_to_camera)
    if z < -1 + 1e-9:  # upside down: about any horizontal axis
        return np.diag([1.0, -1.0, -1.0])
    cross = np.array([[0.0, 0, -x], [0, 0, -y], [x, y, 0]])
    return np.eye(3) + cross + cross @ cross / (1 + z)


def moved_aside(poses: np.ndarray, turns: np.ndarray, shifts: np.ndarray) -> np.ndarray:
    """Return (..., 3, 4) poses of cameras shifted in their own axes by (..., 3), then turned."""
    back = (poses[..., 3] - shifts)[..., None]
    return turns @ np.concatenate([poses[..., :3], back], axis=-1)


def invert_pose(pose: np.ndarray) -> np.ndarray:
    """Invert (..., 3+, 4) rigid poses to (..., 3, 4); those that are not finite stay so."""
    rotation = np.swapaxes(pose[..., :3, :3], -1, -2)
    with np.errstate(invalid="ignore"):
        return np.concatenate([rotation, -rotation @ pose[..., :3, 3:]], axis=-1)


def from_opengl(pose: np.ndarray) -> np.ndarray:
    """Return (..., 3, 4) world-to-camera with OpenCV axes of (..., 3+, 4) camera-to-world poses
    with OpenGL's: y up, z backwards."""
    axes = pose[..., :3, :3] @ OPENGL_TO_OPENCV
    return invert_pose(np.concatenate([axes, pose[..., :3, 3:]], axis=-1))


def pixel_centers(width: int, height: int) -> tuple[np.ndarray, np.ndarray]:
    """Return two (h, w) arrays of the pixels' x and y; the top-left one's are 0.5."""
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    return x, y


def pixel_rays(intrinsics: np.ndarray, width: int, height: int) -> np.ndarray:
    """Return (h, w, 3) rays through the pixels' centres in the camera's axes, with z = 1."""
    x, y = pixel_centers(width, height)
    fx, fy, cx, cy = intrinsics
    return np.stack([(x - cx) / fx, (y - cy) / fy, np.ones_like(x)], axis=-1)


def line_equations(
    points: np.ndarray, axes: np.ndarray, weights: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the normal equations of the point nearest to lines, by weighted squared distances.

    Args:
        points, axes: (n, 3) a point of each line and its unit direction.
        weights: (n,); None for equal ones.

    Returns:
        (3, 3) matrix, (3,) right side, and the (n, 3, 3) projections across the lines.
    """
    across = np.eye(3) - axes[:, :, None] * axes[:, None]
    weighted = across if weights is None else weights[:, None, None] * across
    return weighted.sum(axis=0), np.einsum("nij,nj->i", weighted, points), across


def lengths(vectors: np.ndarray) -> np.ndarray:
    """Return (...) norms of (..., 3) vectors; three times as fast as `np.linalg.norm`."""
    return np.sqrt(np.einsum("...i,...i->...", vectors, vectors))


def viewing_angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return (...) angles between (..., 3) unit vectors, radians in [0, pi].

    2 atan2(|a - b|, |a + b|) (Kahan) is exact for nearly (anti)parallel vectors; those that only
    rounding tells apart are 0 apart.
    """
    chord = lengths(a - b)
    return 2 * np.arctan2(np.where(chord > SAME_AXIS, chord, 0.0), lengths(a + b))


def pairwise_angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return (A, B) radians between every two of (A, 3) and (B, 3) unit vectors."""
    return viewing_angles(a[:, None], b[None])


def pairwise_distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return (A, B) distances of (A, 3) and (B, 3) points, exact also far from the origin."""
    return lengths(a[:, None] - b[None])


def pose_distance(
    centers_a: np.ndarray, axes_a: np.ndarray, centers_b: np.ndarray, axes_b: np.ndarray
) -> np.ndarray:
    """Return the split's (A, B) distance in [0, 2] (paper, section 3.1): of (A, 3) and (B, 3)
    centres, and of axes, each over its maximum."""
    total = np.zeros((len(centers_a), len(centers_b)))
    for part in (pairwise_distances(centers_a, centers_b), pairwise_angles(axes_a, axes_b)):
        top = part.max()
        total += part / (top if top > 0 else 1.0)
    return total


def directions(points: np.ndarray, origins: np.ndarray) -> np.ndarray:
    """Return unit vectors from origins to points; zero where they coincide to rounding."""
    offset = points - origins
    length = lengths(offset)
    least = ROUNDING * max(np.abs(points).max(initial=0.0), np.abs(origins).max(initial=0.0))
    return offset / np.where(length > least, length, np.inf)[..., None]


def reference_points(centers: np.ndarray, axes: np.ndarray, centroid: np.ndarray) -> np.ndarray:
    """Return the (O, 3) points of rays, t >= 0, closest to a (3,) centroid (paper, Appendix A.1),
    given (O, 3) centres and axes."""
    along = np.einsum("oi,oi->o", centroid - centers, axes)
    least = ROUNDING * np.abs(centers).max(initial=0.0)
    return centers + np.where(along > least, along, 0.0)[:, None] * axes


def farthest_views(
    region: np.ndarray, centers: np.ndarray, k: int, start: int | np.ndarray
) -> np.ndarray:
    """Sample the farthest camera centres from a start, or several; at most len(region) frames."""
    chosen = np.atleast_1d(start).tolist()
    gap = np.linalg.norm(centers[region][:, None] - centers[chosen], axis=2).min(axis=1)
    taken = np.isin(region, chosen)
    while len(chosen) < min(k, len(region)):
        best = int(np.argmax(np.where(taken, -1.0, gap)))
        taken[best] = True
        chosen.append(int(region[best]))
        gap = np.minimum(gap, np.linalg.norm(centers[region] - centers[region[best]], axis=1))
    return np.array(chosen)


def check_poses(names: Sequence[str], world_to_camera: np.ndarray, source: str) -> None:
    """Refuse (N, 3, 4) poses that are not finite or no rotations: ValueError naming the frame."""

    def refuse(frame: int, fault: str) -> None:
        raise ValueError(f"{source}: frame {names[frame]!r}: {fault}")

    finite = np.isfinite(world_to_camera).all(axis=(1, 2))
    for i in np.flatnonzero(~finite)[:1]:
        refuse(i, f"pose is not finite: {world_to_camera[i].tolist()}")
    reach = np.abs(world_to_camera[:, :, 3]).max(axis=1).astype(np.float64)
    # of each frame, not of the farthest: a few of the frames are refused as all of them are
    for i in np.flatnonzero(reach * ((reach < LEAST_LENGTH) | (reach > MOST_LENGTH)))[:1]:
        refuse(
            i,
            f"translation is {world_to_camera[i, :, 3].tolist()}; allowed: zero, or a largest part "
            f"of {LEAST_LENGTH:g} to {MOST_LENGTH:g}, whose squares are still numbers",
        )
    rotation = world_to_camera[:, :, :3]
    with np.errstate(over="ignore", invalid="ignore"):  # huge numbers are no rotation either
        off = np.abs(rotation @ rotation.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
        determinant = np.linalg.det(rotation)
    for i in np.flatnonzero(~((off < ROTATION_TOLERANCE) & (determinant > 0)))[:1]:
        refuse(
            i,
            f"rotation has determinant {determinant[i]:.6g} and is {off[i]:.2g} from orthonormal; "
            "a determinant of -1 is a reflection (wrong axis convention), another value an "
            "unnormalised quaternion",
        )


def plane_basis(up: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return two unit vectors that span the plane across a unit vector."""
    first = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    first /= np.linalg.norm(first)
    return first, np.cross(up, first)


def rigid(poses: np.ndarray) -> np.ndarray:
    """Make rotations orthonormal again that were printed with few digits; others stay."""
    if not np.isfinite(poses).all():
        return poses
    left, stretch, right = np.linalg.svd(poses[:, :, :3])
    rounded = np.abs(stretch - 1).max(axis=1) < PRINTED
    mended = np.where(rounded[:, None, None], left @ right, poses[:, :, :3])
    return np.concatenate([mended, poses[:, :, 3:]], axis=2)
