"""One view of a table of Gaussians, and the gradients of its parameters."""

from __future__ import annotations

import numpy as np

from fsel.reconstruct.gaussians import gradients, projection, rasterize, tiles

NEAREST = 0.01  # depth in the normalised frame below which a Gaussian is not drawn


def camera_of(
    world_to_camera: np.ndarray, intrinsics: np.ndarray, size: tuple[int, int], near: float
) -> np.ndarray:
    """Return (22,) float64 numbers of a camera as `projection.project` reads them.

    Args:
        world_to_camera: (3, 4), in the frame of the Gaussians.
        intrinsics: (4,) fx, fy, cx, cy, pixels.
        size: (width, height), pixels.
        near: least depth.
    """
    center = -world_to_camera[:, :3].T @ world_to_camera[:, 3]
    return np.concatenate([world_to_camera.ravel(), center, intrinsics, size, [near]])


class Canvas:
    """Renders views of one (width, height) of tables of at most `most` Gaussians, in buffers.

    `background` is the (3,) colour behind everything; `dtype` is float64 in tests alone.
    """

    def __init__(self, most: int, size: tuple[int, int], background, dtype=np.float32) -> None:
        self.width, self.height = size
        self.background = np.asarray(background, dtype)
        self.image = np.empty((3, self.height, self.width), dtype)
        self.rest = np.empty((self.height, self.width), dtype)
        self._rows = np.empty((most, projection.COLUMNS), dtype)
        self._source = np.empty(most, np.int32)

    def draw(self, table: np.ndarray, degree: int, factor: np.ndarray, camera: np.ndarray):
        """Render into `image`, and the light that passes everything into `rest`.

        Args:
            table: (n, c) parameters.
            degree: of the harmonics in use.
            factor: (n,) factors of the opacities.
            camera: as `camera_of` gives it.

        Returns:
            (v,) int32 rows of the table that are seen, ascending, until the next drawing.
        """
        count, depth = projection.project(table, degree, factor, camera, self._rows, self._source)
        self.source = self._source[:count]
        self.rows, self.rank = tiles.sort_rows(depth[:count], self._rows[:count])
        self.tiles = tiles.assign(self.rows, self.width, self.height)
        rasterize.composite(self.rows, *self.tiles, self.background, self.image, self.rest)
        return self.source

    def backward(self, table, degree, camera, gradient, grad) -> None:
        """Add the last drawing's gradients of the parameters to `grad`, from (3, h, w) of it."""
        sums = np.zeros((len(self.rows), 9), table.dtype)
        rasterize.backward(self.rows, *self.tiles, self.image, gradient, sums)
        gradients.backward(table, degree, camera, self.rows, self.rank, self.source, sums, grad)
