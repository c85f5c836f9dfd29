"""The object that a person wants to see: its position, and where images show it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import cv2
import numpy as np

from fsel.captures.images.masks import load_white, mask_file
from fsel.captures.lazy import LazyCapture
from fsel.core.capture import Capture
from fsel.core.geometry import directions, line_equations
from fsel.core.wording import counted
from fsel.selection.scene_depth import viewing_distance

ROUNDS = 20  # of reweighting; an L1 fit, so that one wrong mask does not move the object


@dataclass(frozen=True)
class Focus:
    """An object in the world.

    Attributes:
        center: (3,) its centre.
        corners: (C, 3) points that stand for it where a view either sees it or not.
        kind: where it was given, in words.
        masks: the folder of its masks, where it was given by them.
    """

    center: np.ndarray
    corners: np.ndarray
    kind: str
    masks: Path | None = None


def focus_of(
    source: Focus | str | Path | Sequence[float] | None, opened: LazyCapture | Capture
) -> Focus | None:
    """Return the object of a folder of masks, or of the six numbers of a box in the scene."""
    if source is None or isinstance(source, Focus):
        return source
    if isinstance(source, str | Path):
        return from_masks(opened if isinstance(opened, Capture) else opened.capture, source)
    box = from_box(np.asarray(source))
    check_within(box, scene_bounds(opened if isinstance(opened, Capture) else opened.with_points()))
    return box


def from_box(values: np.ndarray) -> Focus:
    """An axis-aligned box: x, y, z of one corner, then of the opposite one.

    Raises:
        ValueError: for anything but six finite numbers, a box without extent, or one whose second
            corner is less than the first along an axis.
    """
    ends = np.asarray(values, float).reshape(-1)
    whole = ends.shape == (6,) and bool(np.isfinite(ends).all())
    if not whole or np.all(ends[:3] == ends[3:]) or np.any(ends[:3] > ends[3:]):
        raise ValueError(
            f"box is {ends.tolist()}; allowed: x y z of its minimum corner, then of its maximum, "
            "finite and different"
        )
    corners = np.array(list(product(*ends.reshape(2, 3).T)))
    center = corners.mean(axis=0)
    return Focus(center, np.vstack([center, corners]), "a box")


def check_within(focus: Focus, bounds: np.ndarray) -> None:
    """Refuse an object outside of the (2, 3) `scene_bounds`."""
    low, high = focus.corners.min(axis=0), focus.corners.max(axis=0)
    if np.any(low > bounds[1]) or np.any(high < bounds[0]):
        raise ValueError(
            f"{focus.kind} from {low.round(4).tolist()} to {high.round(4).tolist()} lies outside "
            f"of the scene, which reaches from {bounds[0].round(4).tolist()} to "
            f"{bounds[1].round(4).tolist()} (world units; fsel info prints it)"
        )


def scene_bounds(capture: Capture) -> np.ndarray:
    """(2, 3) least and greatest corner of the box of the cameras and of 98 % of the points; where
    there are none, what the cameras look at stands for them, on all sides of where it is."""
    centers = capture.centers
    if capture.points is not None and len(capture.points.xyz):
        seen = np.percentile(capture.points.xyz, [1, 99], axis=0)
    else:
        far = viewing_distance(capture.views, None)[:, None]
        ahead = centers + far * capture.axes
        seen = np.concatenate([ahead - far, ahead + far])
    shown = np.concatenate([centers, seen])
    return np.stack([shown.min(axis=0), shown.max(axis=0)])


def from_masks(capture: Capture, folder: str | Path) -> Focus:
    """An object from masks, white on black, named like the frames; frames may lack one.

    Raises:
        ValueError: when fewer than two masks show the object, or a file cannot be read.
    """
    folder = Path(folder)
    hint = f"they are named like the frames, for instance {Path(capture.names[0]).stem}.png"
    files = ((row, mask_file(folder, name)) for row, name in enumerate(capture.names))
    masks = ((row, load_white(file)) for row, file in files if file)
    return replace(_seen_in(capture, masks, str(folder), hint), masks=folder)


def from_capture(capture: Capture, frames: np.ndarray) -> Focus:
    """The object that the masks of (n,) frames of a capture show.

    Raises:
        ValueError: when the capture has no masks, or fewer than two of these show the object.
    """
    stored = capture.masks
    if stored is None:
        raise ValueError(f"{capture.source}: has no masks. Hint: give a box, or a folder of masks")
    masks = ((int(row), np.asarray(stored[row])) for row in frames)
    hint = f"the masks of {counted(len(frames), 'frame')} were read"
    return _seen_in(capture, masks, capture.source, hint)


def _seen_in(
    capture: Capture, masks: Iterable[tuple[int, np.ndarray]], where: str, hint: str
) -> Focus:
    """An object from (h, w) masks of frames, each with its frame's number.

    Its centre is the point closest to the rays through the masks' centroids, in the sense of least
    summed distance (iteratively reweighted least squares), which needs no sparse points.
    """
    origins, rays = [], []
    for row, mask in masks:
        if not mask.any():
            continue
        rows, columns = np.nonzero(mask)
        middle = np.array([columns.mean(), rows.mean()]) + 0.5
        pixel = middle / mask.shape[::-1] * capture.size
        x, y = (pixel - capture.intrinsics[row, 2:]) / capture.intrinsics[row, :2]
        rays.append(capture.world_to_camera[row, :, :3].T @ np.array([x, y, 1.0]))
        origins.append(capture.centers[row])
    if len(rays) < 2:
        raise ValueError(
            f"{where}: the object is in {counted(len(rays), 'mask')}, at least two are needed; "
            f"{hint}"
        )
    bearings, weight = directions(np.array(rays), np.zeros(3)), np.ones(len(origins))
    for _ in range(ROUNDS):
        matrix, right, across = line_equations(np.array(origins), bearings, weight)
        center, *_ = np.linalg.lstsq(matrix, right, rcond=None)
        gap = np.linalg.norm(np.einsum("nij,nj->ni", across, center - origins), axis=1)
        weight = 1 / np.maximum(gap, 1e-6 * (1 + gap.max()))
    return Focus(center, center[None], f"{counted(len(rays), 'mask')} in {where}")


def outlines(
    capture: Capture, frames: np.ndarray, focus: Focus | None
) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the frames that show an object, and (n, h, w) where; or all of them and None."""
    if focus is None:
        return frames, None
    # here: numba takes longer to import than a selection takes
    from fsel.metrics.fused import inside

    masks = focus.masks
    shown = boxed(capture, frames, focus) if masks is None else masked(capture, frames, masks)
    kept = inside(shown) > 0
    if not kept.any():
        raise ValueError(
            f"none of {counted(len(frames), 'held-out frame')} shows the object ({focus.kind}): "
            "there is nothing to compare. Hint: hold out other frames with --targets"
        )
    return frames[kept], shown[kept]


def masked(capture: Capture, frames: np.ndarray, folder: Path) -> np.ndarray:
    """(n, h, w) bool of the object's masks in a folder, at the size of the capture's images."""
    width, height = capture.size
    shown = np.zeros((len(frames), height, width), bool)
    for at, frame in enumerate(frames):
        if file := mask_file(folder, capture.names[frame]):
            white = load_white(file).astype(np.uint8)
            shown[at] = cv2.resize(white, capture.size, interpolation=cv2.INTER_NEAREST_EXACT) > 0
    return shown


def boxed(capture: Capture, frames: np.ndarray, box: Focus) -> np.ndarray:
    """(n, h, w) bool, the outline of a box; empty where a corner of it lies behind the camera."""
    width, height = capture.size
    shown = np.zeros((len(frames), height, width), np.uint8)
    for at, frame in enumerate(frames):
        pose, (fx, fy, cx, cy) = capture.world_to_camera[frame], capture.intrinsics[frame]
        x, y, z = (box.corners @ pose[:, :3].T + pose[:, 3]).T
        if np.all(z > 0):
            pixels = np.stack([fx * x / z + cx, fy * y / z + cy], axis=1) - 0.5
            near = np.clip(pixels, -width - height, 2 * (width + height))
            cv2.fillConvexPoly(shown[at], cv2.convexHull(near.round().astype(np.int32)), 1)
    return shown > 0
