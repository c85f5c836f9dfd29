"""Fitted Gaussians: rendering, and the standard `.ply`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fsel.core.capture import Views
from fsel.reconstruct import ply
from fsel.reconstruct.configured import Fitted
from fsel.reconstruct.gaussians.parameters import (
    COLOR,
    LOGIT,
    MEAN,
    SCALE,
    TURN,
    degree_of,
    width_of,
)
from fsel.reconstruct.gaussians.render import NEAREST, Canvas, camera_of
from fsel.reconstruct.selected import Frame


@dataclass(frozen=True)
class GaussianModel(Fitted):
    """A scene of 3D Gaussians."""

    table: np.ndarray  # (n, c) float32 parameters in the model's frame; see `parameters`
    background: np.ndarray  # (3,) colour in [0, 1] where nothing is
    steps: int = 0  # of the optimisation that were made

    @property
    def primitives(self) -> int:
        """Number of Gaussians."""
        return len(self.table)

    @property
    def bytes(self) -> int:
        """Memory of the parameters."""
        return self.table.nbytes

    @property
    def degree(self) -> int:
        """Degree of the spherical harmonics."""
        return degree_of(self.table)

    @property
    def positions(self) -> np.ndarray:
        """(n, 3) float64 centres, world units."""
        return self.table[:, MEAN].astype(np.float64) * self.frame.unit + self.frame.origin

    def render(self, views: Views) -> np.ndarray:
        """Return (T, h, w, 3) float32 images in [0, 1] at the given poses."""
        width, height = views.size
        out = np.empty((len(views), height, width, 3), np.float32)
        canvas = Canvas(len(self.table), views.size, self.background)
        poses, factor = self.frame.local_poses(views.world_to_camera), np.ones(len(self.table))
        for t, image in enumerate(out):
            camera = camera_of(poses[t], views.intrinsics[t], views.size, NEAREST)
            canvas.draw(self.table, self.degree, factor.astype(np.float32), camera)
            image[:] = canvas.image.transpose(1, 2, 0)
        return np.clip(out, 0, 1, out=out)

    def export_ply(self, path: str | Path) -> None:
        """Write the standard `.ply` of Kerbl et al. 2023, in world units, which viewers open.

        Its numbers are float32: far from the world's origin, positions are rounded.
        """
        turn = self.table[:, TURN]
        cloud = ply.Cloud(
            xyz=self.positions,
            harmonics=self.table[:, COLOR:].reshape(self.primitives, (self.degree + 1) ** 2, 3),
            logit=self.table[:, LOGIT],
            log_scale=self.table[:, SCALE] + np.log(self.frame.unit),
            turn=turn / np.linalg.norm(turn, axis=1, keepdims=True),
            background=self.background,
        )
        ply.write(path, cloud)

    @classmethod
    def read_ply(cls, path: str | Path) -> GaussianModel:
        """Read any standard `.ply` of 3D Gaussians, with harmonics to degree three.

        Raises:
            ValueError: naming the file, for what is no such file, or values that are not finite.
        """
        cloud = ply.read(path)
        table = np.empty((len(cloud.xyz), width_of(cloud.degree)), np.float32)
        origin = cloud.xyz.mean(axis=0) if len(cloud.xyz) else np.zeros(3)
        table[:, MEAN] = cloud.xyz - origin
        table[:, SCALE], table[:, TURN] = cloud.log_scale, cloud.turn
        table[:, LOGIT] = cloud.logit
        table[:, COLOR:] = cloud.harmonics.reshape(len(table), width_of(cloud.degree) - COLOR)
        return cls(Frame(origin, 1.0), table, cloud.background)
