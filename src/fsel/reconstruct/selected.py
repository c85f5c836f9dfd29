"""What a reconstruction is made from: the selected frames alone, in coordinates of their own."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fsel.core.capture import Capture
from fsel.core.geometry import centered, pose_matrices
from fsel.core.points import SparsePoints


@dataclass(frozen=True)
class Frame:
    """Origin and unit of a reconstruction's coordinates: float32 holds neither 10^7 metres with
    millimetres between the cameras, nor squares of 10^-30."""

    origin: np.ndarray  # (3,) float64, the middle of the cameras
    unit: float  # their largest distance from it, world units; 1 where all are in one place

    @classmethod
    def of(cls, capture: Capture) -> Frame:
        """Return the frame of a capture's cameras."""
        offset = centered(capture.centers)
        radius = float(np.linalg.norm(offset, axis=1).max())
        return cls(capture.centers[0] - offset[0], radius if radius > 0 else 1.0)

    def local_poses(self, world_to_camera: np.ndarray) -> np.ndarray:
        """Return (N, 3, 4) poses in this frame."""
        rotation = world_to_camera[:, :, :3]
        shift = (rotation @ self.origin + world_to_camera[:, :, 3]) / self.unit
        return pose_matrices(rotation, shift)

    def localised(self, capture: Capture) -> Capture:
        """Return the same capture in this frame."""
        points = capture.points
        if points is not None:
            points = replace(points, xyz=(points.xyz - self.origin) / self.unit)
        poses = self.local_poses(capture.world_to_camera)
        return replace(capture, world_to_camera=poses, points=points)


def distinct(frames: np.ndarray) -> np.ndarray:
    """Return (K,) int64 frames as given; ValueError for fewer than two, which hold no parallax, or
    repeated ones."""
    frames = np.asarray(frames, np.int64)
    if len(frames) < 2 or len(np.unique(frames)) < len(frames):
        raise ValueError(f"need two or more distinct frames, got {frames.tolist()}")
    return frames


def restricted(capture: Capture, frames: np.ndarray) -> Capture:
    """Return the capture of (K,) frames alone, with the points that at least two of them see."""
    own = capture.subset(frames)
    if (points := own.points) is None:
        return own
    track = np.unique(np.stack([points.track_point, points.track_frame]), axis=1)
    kept = np.bincount(track[0], minlength=len(points.xyz)) >= 2
    row = np.cumsum(kept) - 1
    track = track[:, kept[track[0]]]
    shared = SparsePoints(points.xyz[kept], points.rgb[kept], row[track[0]], track[1])
    return replace(own, points=shared)
