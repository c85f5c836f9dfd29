"""Views made from a capture's own cameras, and those of a camera path's file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np

from fsel.captures.parsing import member, number, numbers, read_json, world_transform
from fsel.core.capture import Capture, Views
from fsel.core.geometry import (
    OPENGL_TO_OPENCV,
    check_poses,
    invert_pose,
    line_equations,
    moved_aside,
    plane_basis,
    pose_distance,
    poses_at,
    rigid,
    upwards,
)
from fsel.core.subsets import evenly

GAP = np.radians(60)  # an arc as wide without a camera was not filmed: an orbit leaves it out
SMOOTH = 0.02  # width of a trajectory's smoothing, as a share of the frames
NEIGHBOURS = 4  # frames averaged into a view that stands for a part of the capture
ASIDE = 0.2  # of a capture's reach: standard deviation of a shift along each axis of a camera
TURN = np.radians(12)  # of a turn about each of them


def attention(centers: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """(3,) the point closest to all optical axes, by least squares.

    Raises:
        ValueError: when the cameras look along parallel lines, or mostly away from the point.
    """
    matrix, right, _ = line_equations(centers, axes)
    if np.linalg.cond(matrix) > 1e6:
        raise ValueError("the cameras look along parallel lines: there is no point to orbit")
    point = np.linalg.solve(matrix, right)
    ahead = np.einsum("ni,ni->n", point - centers, axes) > 0
    if ahead.mean() < 0.8:
        raise ValueError(
            f"only {ahead.sum()} of {len(ahead)} cameras look towards a common point: this is not "
            "an orbit. Hint: use `trajectory`"
        )
    return point


def orbit(capture: Capture, count: int) -> Views:
    """Views around the point of attention, at the cameras' median distance and height.

    The part of the circle that no camera filmed (a gap of 60 degrees or more) is left out.
    """
    centers = capture.centers
    point = attention(centers, capture.axes)
    up = upwards(capture.world_to_camera)
    side, ahead = plane_basis(up)
    offset = centers - point
    azimuth = np.arctan2(offset @ ahead, offset @ side)
    ordered = np.sort(azimuth)
    gaps = np.diff(np.append(ordered, ordered[0] + 2 * np.pi))
    largest = int(np.argmax(gaps))
    start, span = ordered[0], 2 * np.pi
    if gaps[largest] >= GAP:
        start, span = ordered[(largest + 1) % len(ordered)], 2 * np.pi - gaps[largest]
    turn = start + span * np.arange(count) / (count if span >= 2 * np.pi else max(count - 1, 1))
    radius = np.median(np.hypot(offset @ side, offset @ ahead))
    height = np.median(offset @ up)
    ring = np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * ahead
    return looking_at(point + radius * ring + height * up, point, up, capture)


def looking_at(centers: np.ndarray, point: np.ndarray, up: np.ndarray, capture: Capture) -> Views:
    """Views from (T, 3) centres towards a point, with the capture's first intrinsics."""
    ahead = point - centers
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    right = np.cross(ahead, up)
    right /= np.maximum(np.linalg.norm(right, axis=1, keepdims=True), 1e-12)
    rotation = np.stack([right, np.cross(ahead, right), ahead], axis=1)
    return views_at(poses_at(centers, rotation), capture)


def trajectory(capture: Capture, count: int) -> Views:
    """Views along the smoothed path of frames in the order of filming, evenly spaced in time.

    Poses are means over neighbouring frames of the same pass.
    """
    n = len(capture)
    passes = np.array(capture.sequences)
    times = np.linspace(0, n - 1, count)
    same = passes[np.round(times).astype(int)][:, None] == passes[None]
    width = max(1.0, SMOOTH * n)
    return _means(capture, np.exp(-0.5 * ((times[:, None] - np.arange(n)) / width) ** 2) * same)


def whole(capture: Capture, count: int) -> Views:
    """Views that stand for all of a capture: means of frames evenly drawn and their neighbours.

    At the frames' own poses, the few that were drawn would be picked, being their own targets.
    Neighbours are found by pose, so that an unordered set of photos works like a video.
    """
    n = len(capture)
    drawn = evenly(n, count)
    distance = pose_distance(
        capture.centers[drawn], capture.axes[drawn], capture.centers, capture.axes
    )
    reach = np.sort(distance, axis=1)[:, min(NEIGHBOURS, n - 1)]
    return _means(capture, np.exp(-0.5 * (distance / np.where(reach > 0, reach, 1)[:, None]) ** 2))


def with_views_beside(views: Views, capture: Capture) -> Views:
    """Some views, and as many off the path: each shifted and turned at random, always alike.

    Shifts follow the axes of the cameras, so that they turn with the world, and scale with the
    greatest distance of the capture's cameras from their mean.
    """
    rng = np.random.default_rng(0)
    reach = np.linalg.norm(capture.centers - capture.centers.mean(axis=0), axis=1).max()
    shift = rng.normal(0, ASIDE * reach, (len(views), 3))
    turn = np.array([cv2.Rodrigues(about)[0] for about in rng.normal(0, TURN, (len(views), 3))])
    off = moved_aside(views.world_to_camera, turn, shift)
    return views.joined(Views(off, views.intrinsics, views.size))


def _means(capture: Capture, weight: np.ndarray) -> Views:
    """Views at (T, N) weighted means of a capture's poses, rotations by the chordal mean."""
    weight = weight / weight.sum(axis=1, keepdims=True)
    left, _, right = np.linalg.svd(
        np.einsum("tn,nij->tij", weight, capture.world_to_camera[:, :, :3])
    )
    flip = np.tile(np.eye(3), (len(weight), 1, 1))
    flip[:, 2, 2] = np.linalg.det(left @ right)
    return views_at(poses_at(weight @ capture.centers, left @ flip @ right), capture)


def views_at(poses: np.ndarray, capture: Capture) -> Views:
    """Views at (T, 3, 4) poses with a capture's first intrinsics."""
    return Views(poses, np.tile(capture.intrinsics[0], (len(poses), 1)), capture.size)


def camera_path(path: Path, capture: Capture) -> Views:
    """Poses of a .json camera path, with the capture's first intrinsics.

    It has nerfstudio's `camera_path` (in the frame of a `dataparser_transforms.json` beside it, if
    there is one), or `frames` with `transform_matrix` as in transforms.json.

    Raises:
        ValueError: for a file that holds neither, or a pose that is no rigid motion.
    """
    content = read_json(path)
    key, field = ("camera_path", "camera_to_world")
    if key not in content:
        key, field = ("frames", "transform_matrix")
    listed = content.get(key)
    if not isinstance(listed, list) or not listed:
        raise ValueError(
            f"{path}: expected a list `camera_path` with `camera_to_world`, or `frames` with "
            "`transform_matrix`, of 4x4 numbers each"
        )
    poses = np.array([_matrix(view, field, path, f"{key}[{i}]") for i, view in enumerate(listed)])
    with np.errstate(over="ignore", invalid="ignore"):  # `check_poses` refuses what comes of it
        poses = _undone(poses, path, content)
        poses[:, :3, :3] = poses[:, :3, :3] @ OPENGL_TO_OPENCV
        inverse = rigid(invert_pose(poses))
    check_poses([f"{key}[{i}]" for i in range(len(inverse))], inverse, str(path))
    return views_at(inverse, capture)


def _matrix(view: object, field: str, path: Path, where: str) -> np.ndarray:
    """(4, 4) of a view's sixteen numbers in a row, four rows of four, or three."""
    value = member(view, field, path, where)
    rows = len(value) if isinstance(value, list) else 0
    shape = (16,) if rows == 16 else (3, 4) if rows == 3 else (4, 4)
    pose = numbers(value, shape, path, f"{field} of {where}").reshape(-1, 4)
    if not np.isfinite(pose).all():
        raise ValueError(f"{path}: {field} of {where} must be finite, got {repr(value)[:80]}")
    return np.vstack([pose[:3], [0, 0, 0, 1]])


def _undone(poses: np.ndarray, path: Path, content: dict[str, Any]) -> np.ndarray:
    """Camera-to-world poses without the world transform that the file or its neighbour states."""
    beside = path.with_name("dataparser_transforms.json")
    scale, stored, source = 1.0, content.get("applied_transform"), path
    what = "applied_transform"
    if "camera_path" in content and beside.is_file():
        stated, source, what = read_json(beside), beside, "transform"
        scale = number(member(stated, "scale", beside), beside, "scale")
        stored = member(stated, "transform", beside)
        if scale <= 0:
            raise ValueError(f"{beside}: scale is {scale:g}; allowed: more than 0")
    if stored is None:
        return poses
    stored = stored[:3] if isinstance(stored, list) else stored
    full = np.vstack([world_transform(stored, source, what), [0, 0, 0, 1]])
    unscaled = poses.copy()
    unscaled[:, :3, 3] /= scale
    return np.linalg.inv(full) @ unscaled
