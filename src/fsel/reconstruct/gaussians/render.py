"""One view of a table of Gaussians, and the gradients of its parameters."""

from __future__ import annotations

from functools import partial

import numpy as np

from fsel.core.threads import ranges, spread
from fsel.reconstruct.gaussians import gradients, projection, rasterize, tiles

FEWEST, FEWEST_TILES, FEWEST_ROWS = 512, 8, 4  # Gaussians, tiles, rows of them, of a range
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
        self._parts = np.empty((0, 9), dtype)  # sums of each Gaussian on each tile

    def draw(self, table: np.ndarray, degree: int, factor: np.ndarray, camera: np.ndarray):
        """Render into `image`, and the light that passes everything into `rest`.

        Args:
            table: (n, c) parameters.
            degree: of the harmonics in use.
            factor: (n,) factors of the opacities.
            camera: as `camera_of` gives it.

        Returns:
            (v,) int32 rows of the table that are seen, ascending.
        """
        self._project(table, degree, factor, camera)
        size, down = (self.width, self.height), -(-self.height // tiles.TILE)
        bands = ranges(down, FEWEST_ROWS, 1)
        self.tiles = tiles.joined(spread(partial(tiles.assign, self.rows, *size), bands))
        out = self.background, self.image, self.rest
        spread(partial(rasterize.composite, self.rows, *self.tiles, *out), self._ranges())
        return self.source

    def _ranges(self):
        return ranges(len(self.tiles[0]) - 1, FEWEST_TILES)

    def _project(self, table, degree, factor, camera) -> None:
        """Fill the projected Gaussians, nearest first, and where each comes from."""

        def project(first: int, last: int):
            cut = slice(first, last)
            given = table[cut], degree, factor[cut], camera
            count, depth = projection.project(*given, self._rows[cut], self._source[cut])
            place = np.arange(first, first + count, dtype=np.int32)
            return depth[:count], place, self._source[place] + np.int32(first)

        made = spread(project, ranges(len(table), FEWEST))
        depth, place, self.source = (np.concatenate(parts) for parts in zip(*made, strict=True))
        self.rows = np.empty((len(depth), projection.COLUMNS), self._rows.dtype)
        self.rank = np.empty(len(depth), np.int32)
        given = tiles.by_depth(depth), place, self._rows, self.rows, self.rank
        spread(partial(tiles.arrange, *given), ranges(len(depth), FEWEST))

    def backward(self, table, degree, camera, gradient, grad) -> None:
        """Add the last drawing's gradients of the parameters to `grad`, from (3, h, w) of it."""
        sums, (starts, members) = np.zeros((len(self.rows), 9), table.dtype), self.tiles
        given, parts = (self.rows, starts, members, self.image, gradient), self._ranges()
        apart = len(parts) > 1
        if apart and len(self._parts) < len(members):
            self._parts = np.empty((len(members), 9), table.dtype)

        def tiled(first: int, last: int) -> None:
            if apart:
                self._parts[starts[first] : starts[last]] = 0
            out = self._parts if apart else sums
            rasterize.backward(*given, out, apart, first, last)

        spread(tiled, parts)
        if apart:  # sums are added in the order of the tiles, as on one thread
            gather = partial(rasterize.gather, starts, members, self._parts, sums)
            spread(gather, ranges(len(sums), FEWEST, 1))

        def parameters(first: int, last: int) -> None:
            rank, source = self.rank[first:last], self.source[first:last]
            gradients.backward(table, degree, camera, self.rows, rank, source, sums, grad)

        spread(parameters, ranges(len(sums), FEWEST))
