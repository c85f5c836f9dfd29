"""One pass over a capture's images, poses and points that finds its bad frames."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np

from fsel.data.geometry import pose_distance
from fsel.data.points import RawPoints, grouped_rows
from fsel.health import blur, covered, exposure, findings, poses
from fsel.health.cells import GRID, SIDE, Cells, measured, sharpness
from fsel.health.duplicates import STILL, duplicates
from fsel.health.findings import Finding, Health, exceeding
from fsel.images.previews import Progress, in_silence, in_turn, shrunk
from fsel.ingest.agreement import reprojection_errors
from fsel.ingest.lazy import LazyCapture

NEAR = 4  # frames closest to each by pose
BLOCK = 1000  # frames whose distances from all others are in memory at once
THUMBNAIL = 96  # pixels of the longer side of images that are compared as wholes
MOST_POINTS = 200  # of each frame, those in the longest tracks, that colors are compared at
BURNT = 0.3  # share of the pixels clipped to white above that of the frames beside
SHOWN = 0.5  # share of a frame's points that others must see to show what it shows


def examined(
    opened: LazyCapture, progress: Progress = in_silence, *, images: bool = True
) -> Health:
    """Find the bad frames of a capture.

    Args:
        opened: the capture.
        progress: wraps the loop over the images.
        images: whether they are opened; without, poses alone are judged.

    Raises:
        ValueError: for an unreadable image, named.
    """
    scene = _Scene(opened)
    found, sharp = scene.poses(), None
    if images and len(opened.capture) > NEAR:
        longest, files = opened.longest, opened.raw.images

        def look(at: int) -> tuple:
            image = shrunk(files[at], longest, SIDE)
            scale = THUMBNAIL / max(image.shape[:2])
            grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
            small = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
            return measured(image), small, max(image.shape[:2])

        cells, small, sides = zip(*in_turn(look, files, progress), strict=True)
        scene = replace(scene, cells=Cells.of(cells), sides=np.array(sides))
        found += [*scene.blurred(), *scene.exposed(), *scene.covered(found)]
        found += scene.duplicates(small)
        detail = sharpness(scene.cells).min(axis=1)
        sharp = np.exp(detail - np.nanmax(detail)) if np.isfinite(detail).any() else None
    found.sort(key=lambda finding: (finding.frame, -finding.severity))
    gone = findings.left_out(tuple(found), len(opened.capture), scene.shown)
    return Health(tuple(found), sharp, gone)


@dataclass(frozen=True)
class _Scene:
    """A capture with what was measured of its images.

    Attributes:
        opened: the capture.
        cells: of its images.
        sides: (N,) pixels of the longer side of the images that were measured.
    """

    opened: LazyCapture
    cells: Cells | None = None
    sides: np.ndarray | None = None

    @property
    def names(self) -> tuple[str, ...]:
        return self.opened.capture.names

    @cached_property
    def near(self) -> np.ndarray:
        """(N, 4) frames closest to each by pose."""
        centers, axes = self.opened.capture.centers, self.opened.capture.axes
        rows = []
        for block in np.array_split(np.arange(len(centers)), len(centers) // BLOCK + 1):
            distance = pose_distance(centers[block], axes[block], centers, axes)
            distance[np.arange(len(block)), block] = np.inf
            rows.append(np.argsort(distance, axis=1, kind="stable")[:, :NEAR])
        return np.concatenate(rows)

    @cached_property
    def points(self) -> RawPoints | None:
        """Sparse points in the longest tracks of each frame."""
        points = self.opened.points
        if points is None or not len(points.track_frame):
            return None
        length = np.bincount(points.track_point, minlength=len(points.xyz))
        chosen = np.zeros(len(points.xyz), bool)
        for rows in grouped_rows(points.track_frame, len(self.names)):
            seen = points.track_point[rows]
            chosen[seen[np.argsort(-length[seen], kind="stable")[:MOST_POINTS]]] = True
        kept = chosen[points.track_point]
        return replace(
            points,
            track_point=points.track_point[kept],
            track_frame=points.track_frame[kept],
            track_xy=points.track_xy[kept],
        )

    @cached_property
    def rows(self) -> list[np.ndarray]:
        """Observations of each frame."""
        return grouped_rows(self.points.track_frame, len(self.names))

    def cell(self, pixels: np.ndarray, frame: np.ndarray) -> np.ndarray:
        """(L,) cells at (L, 2) pixels of frames as their cameras state them."""
        cameras = self.opened.raw.cameras
        stated = np.array([max(camera.width, camera.height) for camera in cameras])
        return self.cells.at(pixels, (self.sides / stated)[frame])

    @cached_property
    def seen_at(self) -> np.ndarray:
        """(L,) cell of each observation."""
        return self.cell(self.points.track_xy, self.points.track_frame)

    @cached_property
    def gains(self) -> tuple[np.ndarray, np.ndarray | None]:
        """(N, 3) logarithms of the frames' gains and, where there are points, of their colors."""
        if self.points is None:
            return exposure.gains_beside(self.cells, self.near), None
        seen = self.points
        return exposure.gains_at_points(
            self.cells, self.seen_at, seen.track_point, seen.track_frame
        )

    def poses(self) -> list[Finding]:
        """Frames whose poses contradict their points or, without points, the path beside them."""
        raw, count = self.opened.raw, len(self.names)
        judged, found = np.zeros(count, bool), []
        if self.opened.points is not None:
            points = self.opened.points
            side = max(max(camera.width, camera.height) for camera in raw.cameras)
            errors = reprojection_errors(raw, points)
            median, limit, within = poses.reprojection(errors, points.track_frame, count, side)
            judged = ~np.isnan(median)
            found = exceeding(findings.MISPLACED, median, limit, "pixels of reprojection error")
            found = [
                one._replace(measure=f"{one.measure}, {within[one.frame]:.0%} of its points fit")
                for one in found
            ]
        off = np.zeros(count)
        for label in dict.fromkeys(raw.sequences):
            rows = np.flatnonzero([sequence == label for sequence in raw.sequences])
            off[rows] = poses.jumps(raw.world_to_camera[rows])
        off[judged] = 0
        what = "times as far off the path beside it as a smooth one lies"
        return found + exceeding(findings.MISPLACED, off, 1.0, what)

    def blurred(self) -> list[Finding]:
        """Frames with less detail than they should have; the worst of three reasons of each."""
        detail = sharpness(self.cells)
        by = {
            "the frames beside it": (blur.beside(detail, self.near), blur.BESIDE),
            "the capture's sharpest tenth": (blur.of_capture(detail), blur.OF_CAPTURE),
        }
        if self.points is not None:
            seen = self.points
            lost = blur.at_points(self.cells, self.seen_at, seen.track_point, seen.track_frame)
            by["sharp frames at the points that it sees"] = lost, blur.AT_POINTS
        worst: dict[int, Finding] = {}
        for what, (times, limit) in by.items():
            measure = f"times less detail than {what}"
            for one in exceeding(findings.BLURRED, times, limit, measure):
                worst[one.frame] = max(one, worst.get(one.frame, one), key=lambda f: f.severity)
        return list(worst.values())

    def exposed(self) -> list[Finding]:
        """Frames that are too bright, too dark or of another tint than the others, or burnt out."""
        times, most, tint, tinted = exposure.unusual(self.gains[0])
        clipped = self.cells.clipped
        usual = np.median(clipped[self.near], axis=1) + BURNT
        return [
            *exceeding(findings.EXPOSED, times, most, "times brighter or darker than the capture"),
            *exceeding(findings.TINTED, tint, tinted, "times as strong a channel as usual"),
            *exceeding(findings.BURNT, clipped, usual, "of the image clipped to white"),
        ]

    def covered(self, others: list[Finding]) -> list[Finding]:
        """Frames whose middle is hidden, but those that are known to be misplaced."""
        if self.points is None:
            return []
        share = np.array([self._hidden(frame) for frame in range(len(self.names))])
        share[[one.frame for one in others]] = np.nan
        what = "of the points expected in its middle hidden"
        return exceeding(findings.COVERED, share, covered.HIDDEN, what)

    def _hidden(self, frame: int) -> float:
        """Share of what two frames beside one see in its middle and it does not."""
        raw, points, (gains, colors) = self.opened.raw, self.points, self.gains
        beside = [points.track_point[self.rows[near]] for near in self.near[frame]]
        expected, times = np.unique(np.concatenate(beside), return_counts=True)
        expected = expected[times > 1]
        pose, camera = raw.world_to_camera[frame], raw.cameras[frame]
        local = points.xyz[expected] @ pose[:, :3].T + pose[:, 3]
        expected, local = expected[local[:, 2] > 0], local[local[:, 2] > 0]
        if not len(local):
            return float("nan")
        pixels = np.asarray(camera.colmap.img_from_cam(local))
        inside = covered.in_the_middle(pixels, (camera.width, camera.height))
        expected, pixels = expected[inside], pixels[inside]
        cell = self.cell(pixels, np.full(len(pixels), frame))
        color = self.cells.color[frame].reshape(3, GRID * GRID)[:, cell].T
        observed = np.isin(expected, points.track_point[self.rows[frame]])
        return covered.hidden(color, np.exp(colors[expected] + gains[frame]), observed)

    def duplicates(self, small: tuple[np.ndarray, ...]) -> list[Finding]:
        """Frames that show the same as the one before them."""
        if len({image.shape for image in small}) > 1:
            return []
        again = np.flatnonzero(~duplicates(np.array(small)))
        what = "of the image's side moved since the frame before"
        return [Finding(int(i), findings.DUPLICATE, 0.0, STILL, what) for i in again]

    def shown(self, frame: int, staying: np.ndarray) -> bool:
        """Whether frames show what one shows: its points or, without any, from near its pose."""
        if self.points is not None and len(self.rows[frame]):
            points = self.points
            seen = np.zeros(len(points.xyz), bool)
            seen[points.track_point[staying[points.track_frame]]] = True
            return bool(seen[points.track_point[self.rows[frame]]].mean() >= SHOWN)
        return bool(staying[self.near[frame]].any())
