"""The coordinates that a reconstruction is made in."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fsel.core.capture import Capture
from fsel.core.geometry import centered, pose_matrices


@dataclass(frozen=True)
class Frame:
    """Origin and unit of a reconstruction's coordinates: float32 holds neither 10^7 metres with
    millimetres between the cameras, nor squares of 10^-30.

    Attributes:
        origin: (3,) float64, the middle of the cameras.
        unit: their largest distance from it, world units; 1 where all are in one place.
    """

    origin: np.ndarray
    unit: float

    @classmethod
    def of(cls, capture: Capture) -> Frame:
        """The frame of a capture's cameras."""
        offset = centered(capture.centers)
        radius = float(np.linalg.norm(offset, axis=1).max())
        return cls(capture.centers[0] - offset[0], radius if radius > 0 else 1.0)

    def local_poses(self, world_to_camera: np.ndarray) -> np.ndarray:
        """(N, 3, 4) poses in this frame."""
        rotation = world_to_camera[:, :, :3]
        shift = (rotation @ self.origin + world_to_camera[:, :, 3]) / self.unit
        return pose_matrices(rotation, shift)

    def localised(self, capture: Capture) -> Capture:
        """The same capture in this frame."""
        points = capture.points
        if points is not None:
            points = replace(points, xyz=(points.xyz - self.origin) / self.unit)
        poses = self.local_poses(capture.world_to_camera)
        return replace(capture, world_to_camera=poses, points=points)
