"""Agreement of a capture's poses, cameras and images, measured at ingestion."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from fsel.captures.colmap.undistortion import Lens, Lenses
from fsel.captures.images import files as image_files
from fsel.captures.images.matching import choose_pairs, epipolar_distances, match
from fsel.captures.layouts.contract import RawCapture
from fsel.captures.layouts.nerfstudio import NEW_APPLIED_TRANSFORM, OLD_APPLIED_TRANSFORM
from fsel.core.geometry import OPENGL_TO_OPENCV, invert_pose
from fsel.core.points import RawPoints, grouped_rows

PAIRS = 8
MATCHING_LONG_SIDE = 640
MIN_MATCHES = 60  # over all pairs, below which nothing is concluded
SCALES = (0.125, 0.25, 0.5, 2.0, 4.0, 8.0)
UNKNOWN = "poses and images (or points) that belong to different reconstructions"


@dataclass(frozen=True)
class Agreement:
    """Measure of how well a capture's parts agree, in pixels of its images."""

    kind: str  # `reprojection` of sparse points, `epipolar` distance of matches, or `none`
    median: float  # nan for none
    p95: float  # 95th percentile
    long_side: int  # longer side of the images
    count: int  # observations or matches measured
    cause: str = ""  # the mistake that would explain a large median, in words

    def __str__(self) -> str:
        if not self.count:
            return "no sparse points and too few matches to check the poses with"
        return (
            f"{self.kind} error of median {self.median:.2f} px and 95th percentile {self.p95:.2f} "
            f"px over {self.count}, in images of {self.long_side} px"
        )

    @property
    def share(self) -> float:
        """The median as a share of the longer side."""
        return self.median / self.long_side


NOT_MEASURED = Agreement("none", np.nan, np.nan, MATCHING_LONG_SIDE, 0)


def measure(raw: RawCapture, bound: float) -> Agreement:
    """Reproject the sparse points or match a few pairs of frames; above `bound`, find the cause."""
    points = raw.sparse()
    if points is not None and len(points.track_xy):
        side = max(max(camera.width, camera.height) for camera in raw.cameras)
        return _agreement("reprojection", reprojection_errors, raw, side, bound)
    matches = list(_matches(raw, choose_pairs(raw.world_to_camera, PAIRS)))
    if sum(len(m[2]) for m in matches) < MIN_MATCHES:
        return NOT_MEASURED
    side = max(max(m[6]) for m in matches)
    return _agreement("epipolar", lambda r: _epipolar(r, matches), raw, side, bound)


def _agreement(
    kind: str, errors: Callable[[RawCapture], np.ndarray], raw: RawCapture, side: int, bound: float
) -> Agreement:
    pixels = errors(raw)
    # not interpolated: between a number and the infinity of a point behind its camera lies nan
    median, p95 = (float(v) for v in np.percentile(pixels, [50, 95], method="higher"))
    cause = ""
    if median > bound * side:
        trials = {name: float(np.median(errors(changed))) for name, changed in _mistakes(raw)}
        best = min(trials, key=trials.__getitem__)
        cause = best if trials[best] <= bound * side else UNKNOWN
    return Agreement(kind, median, p95, side, len(pixels), cause)


def reprojection_errors(raw: RawCapture, points: RawPoints | None = None) -> np.ndarray:
    """(L,) pixels between each observation and its point's projection; inf behind the camera."""
    points = points or raw.sparse()
    if points is None:
        return np.empty(0)
    errors = np.full(len(points.track_xy), np.inf)
    for frame, rows in enumerate(grouped_rows(points.track_frame, len(raw.names))):
        ahead, seen = raw.projected(frame, points.xyz[points.track_point[rows]])
        # the squares of a damaged camera's positions may be no numbers
        errors[rows[ahead]] = np.hypot(*(seen - points.track_xy[rows[ahead]]).T)
    return np.where(np.isnan(errors), np.inf, errors)


def _matches(raw: RawCapture, pairs: list[tuple[int, int]]) -> Iterator[tuple]:
    """(i, j, pixels in i, in j, intrinsics of i, of j, size) of pairs that match, undistorted."""
    lenses = Lenses(MATCHING_LONG_SIDE)

    @cache
    def show(i: int) -> tuple[np.ndarray, Lens]:
        image = image_files.load_for(raw.images[i], MATCHING_LONG_SIDE)
        lens = lenses.of(raw.cameras[i], image, raw.images[i])
        return lens.straighten(image), lens

    for i in sorted({i for pair in pairs for i in pair}):
        show(i)  # in order, so that a video is read once
    for i, j in pairs:
        (first, a), (second, b) = show(i), show(j)
        xa, xb = match(first, second)
        if len(xa):
            yield i, j, xa, xb, a.intrinsics, b.intrinsics, a.size


def _epipolar(raw: RawCapture, matches: list[tuple]) -> np.ndarray:
    found, poses = [], raw.world_to_camera
    for i, j, xa, xb, ka, kb, _ in matches:
        found.append(epipolar_distances(xa, xb, poses[i], poses[j], ka, kb))
    return np.concatenate(found)


def _mistakes(raw: RawCapture) -> Iterator[tuple[str, RawCapture]]:
    """Yield the capture with each common mistake undone, and the mistake's name."""
    poses = raw.world_to_camera
    full = np.concatenate([poses, np.tile([[[0.0, 0, 0, 1]]], (len(poses), 1, 1))], axis=1)
    opengl = np.diag([1.0, -1, -1, 1])
    changed = [
        ("camera axes of OpenGL (y up, z back) taken for OpenCV's", OPENGL_TO_OPENCV @ poses),
        ("camera-to-world poses taken for world-to-camera", invert_pose(poses)),
        (
            "camera-to-world poses with OpenGL axes taken for world-to-camera",
            invert_pose(full @ opengl),
        ),
    ]
    for name, applied in (("before", OLD_APPLIED_TRANSFORM), ("since", NEW_APPLIED_TRANSFORM)):
        world = np.vstack([applied, [0, 0, 0, 1]])
        what = f"the applied_transform of nerfstudio {name} January 2024, kept or undone wrongly"
        changed += [(what, (full @ matrix)[:, :3]) for matrix in (world, world.T)]
    for what, other in changed:
        yield what, replace(raw, world_to_camera=other)
    points = raw.sparse()
    if points is None:
        return
    for scale in SCALES:
        what = f"intrinsics {scale:g} times as large as the pixels that points were seen at"
        yield what, _with_points(raw, replace(points, track_xy=points.track_xy * scale))


def _with_points(raw: RawCapture, points: RawPoints) -> RawCapture:
    return replace(raw, points=lambda _: points)
