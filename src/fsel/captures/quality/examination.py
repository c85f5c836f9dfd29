"""One pass over a capture's images, poses and points that finds its bad frames."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

import cv2
import numpy as np

from fsel.captures.images.previews import (
    MOST_SHOWN,
    Progress,
    in_silence,
    in_turn,
    jpeg,
    picture_side,
    reduced,
    shrunk,
)
from fsel.captures.lazy import LazyCapture, open_capture
from fsel.captures.poses.agreement import reprojection_errors
from fsel.captures.quality import findings, photometry, poses
from fsel.captures.quality.cells import SIDE, Cells, measured, sharpness
from fsel.captures.quality.findings import Finding, Health, exceeding
from fsel.captures.quality.photometry import STILL, movements
from fsel.core.geometry import pose_distance
from fsel.core.points import NO_POINTS, RawPoints, grouped_rows

NEAR = 4  # frames closest to each by pose
BLOCK = 1000  # frames whose distances from all others are in memory at once
THUMBNAIL = 96  # pixels of the longer side of images that are compared as wholes
MOST_POINTS = 200  # of each frame, those in the longest tracks, that colors are compared at
PIXELS = "pixels of reprojection error, {:.0%} of its points fit"
OFF_PATH = "times the distance allowed from a smooth path"
TURNED = "degrees turned since the previous frame"
SHOWN = 0.5  # share of a frame's points that another must see to show what it shows
LEAST_SEEN = 60  # points of a frame that stand for what it shows


def examined(
    opened: LazyCapture,
    progress: Progress = in_silence,
    *,
    images: bool = True,
) -> Health:
    """Find the bad frames of a capture, by poses alone without `images`; pictures are as small as a
    page of all frames wants them."""
    placed = _Placed(opened)
    found, detail, pictures = placed.misplaced(), None, {}
    if images and len(opened.capture) > NEAR:
        seen = in_turn(lambda at: _look(opened, at), opened.raw.images, progress)
        cells, small, sides, made = zip(*seen, strict=True)
        pictures = {at: one for at, one in enumerate(made) if one}
        pictured = _Pictured(placed, Cells.of(cells), np.array(sides))
        found += [*pictured.blurred(), *pictured.exposed()]
        unreadable = (np.array(sides) == 1) * 1.0
        found += exceeding(findings.UNREADABLE, unreadable, 0.0, "image that no decoder reads")
        found += _duplicates(small)
        known = np.exp(sharpness(pictured.cells).min(axis=1))
        detail = known if np.isfinite(known).any() else None
    found.sort(key=lambda finding: finding.severity)
    worst = {(finding.frame, finding.kind): finding for finding in found}.values()
    found = sorted(worst, key=lambda finding: (finding.frame, -finding.severity))
    gone, alone = findings.left_out(tuple(found), len(opened.capture), placed.shown)
    return Health(tuple(found), detail, gone, alone, pictures)


def bad_frames(path: str | Path, layout: str = "auto") -> list[str]:
    """Name the frames of a capture that `fsel select` leaves out, the least bad first.

    Args:
        path: its folder.
        layout: a key of `LAYOUTS`, or `auto` to recognise it.

    Raises:
        FileNotFoundError, ValueError: as `fsel.read_capture`.

    Example:
        >>> bad = fsel.bad_frames("captures/garden")
        >>> chosen = fsel.select("captures/garden", 20, targets="every:8", never=bad)
    """
    opened = open_capture(path, layout)
    return [opened.capture.names[frame] for frame in examined(opened).left_out]


def _look(opened: LazyCapture, at: int) -> tuple[tuple, np.ndarray, int, bytes | None]:
    """The cells of a frame's image, the image small and grey, the side that was measured, and the
    picture of a page, so that no frame is decoded for it again."""
    try:
        image = shrunk(opened.raw.images[at], opened.longest, SIDE)
        count = len(opened.raw.names)
        made = jpeg(reduced(image, picture_side(count))) if count <= MOST_SHOWN else None
    except ValueError:  # no decoder takes it
        image, made = np.zeros((1, 1, 3), np.uint8), None
    side = max(image.shape[:2])
    grey, scale = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), min(1.0, THUMBNAIL / side)
    small = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return measured(image), small, side, made


def _duplicates(small: tuple[np.ndarray, ...]) -> list[Finding]:
    """Return frames that show the same as the one before them, of those of one shape."""
    what, moved = "of the image's side moved since the previous frame", np.full(len(small), np.inf)
    for shape in {image.shape for image in small if image.size > 1}:
        rows = [at for at, image in enumerate(small) if image.shape == shape]
        moved[rows] = movements(np.array([small[at] for at in rows]))
    again = np.flatnonzero(moved < STILL)
    return [Finding(int(i), findings.DUPLICATE, float(moved[i]), STILL, what) for i in again]


class _Placed:
    """A capture's poses and points, and the rows of each frame's observations."""

    def __init__(self, opened: LazyCapture) -> None:
        self.opened = opened
        self.points = opened.points or NO_POINTS
        self.rows = grouped_rows(self.points.track_frame, len(opened.capture))

    @cached_property
    def near(self) -> np.ndarray:
        """(N, 4) frames closest to each by pose."""
        centers, axes = self.opened.capture.centers, self.opened.capture.axes
        near = []
        for block in np.array_split(np.arange(len(centers)), len(centers) // BLOCK + 1):
            distance = pose_distance(centers[block], axes[block], centers, axes)
            distance[np.arange(len(block)), block] = np.inf
            near.append(np.argsort(distance, axis=1, kind="stable")[:, :NEAR])
        return np.concatenate(near)

    @cached_property
    def by_point(self) -> list[np.ndarray]:
        """The rows of each point's observations."""
        return grouped_rows(self.points.track_point, len(self.points.xyz))

    def misplaced(self) -> list[Finding]:
        """Frames whose poses contradict their points or, without points, the path beside them."""
        raw, count = self.opened.raw, len(self.rows)
        side = max(max(camera.width, camera.height) for camera in raw.cameras)
        errors = reprojection_errors(raw, self.points)
        median, limit, within = poses.reprojection(errors, self.points.track_frame, count, side)
        found = [
            Finding(i, findings.MISPLACED, float(median[i]), limit, PIXELS.format(within[i]))
            for i in np.flatnonzero(median > limit).tolist()
        ]
        off, labels = np.zeros(count), np.array(raw.sequences)
        for label in dict.fromkeys(raw.sequences):
            of_pass = np.flatnonzero(labels == label)
            off[of_pass] = poses.jumps(raw.world_to_camera[of_pass])
        off[~np.isnan(median)] = 0
        turns = {
            jump["name"]: jump["degrees"] for jump in (self.opened.found or {}).get("jumps", ())
        }
        turned = np.array([turns.get(name, 0) for name in raw.names])
        found += exceeding(findings.MISPLACED, turned, poses.AWAY, TURNED)
        return found + exceeding(findings.MISPLACED, off, 1.0, OFF_PATH)

    def shown(self, frame: int, staying: np.ndarray) -> bool:
        """Return whether one frame that stays shows half of a frame's points or, of few, is one of
        the closest to it by pose."""
        seen = self.points.track_point[self.rows[frame]]
        if len(seen) < LEAST_SEEN:
            return bool(staying[self.near[frame]].any())
        rows = np.concatenate([self.by_point[point] for point in seen])
        shared = np.bincount(self.points.track_frame[rows], minlength=len(staying))
        return bool(shared[staying].max(initial=0) >= SHOWN * len(seen))


class _Pictured:
    """Cells of a capture's images, and where the points in each frame's longest tracks lie."""

    def __init__(self, placed: _Placed, cells: Cells, sides: np.ndarray) -> None:
        """Args: the capture; cells of its images; (N,) the longer sides that they were of."""
        self.placed, self.cells = placed, cells
        cameras = placed.opened.raw.cameras
        scale = sides / [max(camera.width, camera.height) for camera in cameras]
        points = _longest(placed.points, placed.rows)
        cell = cells.at(points.track_xy, scale[points.track_frame])
        self._tracks = cells, cell, points.track_point, points.track_frame

    def blurred(self) -> list[Finding]:
        """Return frames with less detail than what shows the same, by two references."""
        detail, near, found = sharpness(self.cells), self.placed.near, []
        same = photometry.same_content(self.cells, near)
        beside = photometry.blur_beside(detail, near, same)
        at_points = photometry.blur_at_points(*self._tracks)
        for times, limit, what in (
            (beside, photometry.BESIDE, "the frames beside it that show the same"),
            (at_points, photometry.AT_POINTS, "sharp frames at the points that it sees"),
        ):
            found += exceeding(findings.BLURRED, times, limit, f"times less detail than {what}")
        return found

    def exposed(self) -> list[Finding]:
        """Frames that are too bright or too dark beside the others."""
        if len(self._tracks[3]):
            gains = photometry.gains_at_points(*self._tracks)
        else:
            gains = photometry.gains_beside(self.cells, self.placed.near)
        what = "times brighter or darker than the capture"
        return exceeding(findings.EXPOSED, *photometry.unusual_gains(gains), what)


def _longest(points: RawPoints, rows: list[np.ndarray]) -> RawPoints:
    """Return the observations of the points in the longest tracks of each frame."""
    length = np.bincount(points.track_point, minlength=len(points.xyz))
    chosen = np.zeros(len(points.xyz), bool)
    for row in rows:
        seen = points.track_point[row]
        chosen[seen[np.argsort(-length[seen], kind="stable")[:MOST_POINTS]]] = True
    return points.observed(chosen[points.track_point])
