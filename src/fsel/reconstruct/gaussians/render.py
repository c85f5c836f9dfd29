"""One view of a table of Gaussians, and the gradients of its parameters."""

from __future__ import annotations

from functools import partial

import numpy as np

from fsel.core.threads import InOrder, ranges, spread
from fsel.reconstruct.gaussians import gradients, projection, rasterize, tiles

FEWEST, FEWEST_LINES, FEWEST_TILES = 1024, 3, 16  # Gaussians, rows of tiles, tiles of a range
BANDS, PARTS = 6, 12  # of a thread: ranges of rows of tiles, and of tiles, which take unequal times
NEAREST = 0.01  # depth in the normalised frame below which a Gaussian is not drawn


def camera_of(
    world_to_camera: np.ndarray, intrinsics: np.ndarray, size: tuple[int, int], near: float
) -> tuple[float, ...]:
    """Return the 22 numbers of a camera as `projection.project` reads them, of its (3, 4) pose in
    the Gaussians' frame, (4,) intrinsics and (width, height) in pixels, and least depth."""
    center = -world_to_camera[:, :3].T @ world_to_camera[:, 3]
    read = np.concatenate([world_to_camera.ravel(), center, intrinsics, size, [near]])
    return tuple(read.tolist())


class Canvas:
    """Renders views of one (width, height) of tables of at most `most` Gaussians, in buffers.

    `background` is the (3,) colour behind everything.
    """

    def __init__(self, most: int, size: tuple[int, int], background) -> None:
        self.width, self.height = size
        self.background = np.asarray(background, np.float32)
        self.image = np.empty((3, self.height, self.width), np.float32)
        self.rest = np.empty((self.height, self.width), np.float32)
        self._rows = np.empty((most, projection.COLUMNS), np.float32)
        self._source = np.empty(most, np.int32)
        self._parts = np.empty((0, rasterize.SUMS), np.float32)  # of each Gaussian on each tile

    def draw(self, table: np.ndarray, degree: int, factor: np.ndarray, camera: tuple):
        """Render an (n, c) table's Gaussians, their opacities times (n,) `factor`, into `image`,
        and the light that passes into `rest`; return the (v,) int32 rows that are seen,
        ascending."""
        self._project(table, degree, factor, camera)
        across, down = -(-self.width // tiles.TILE), -(-self.height // tiles.TILE)
        out = self.background, self.image, self.rest

        def band(top: int, bottom: int):
            made = tiles.assign(self.rows, self._lines, self.width, top, bottom)
            room = rasterize.room()
            rasterize.composite(self.rows, *made, room, *out, top * across)
            return made

        self.tiles = tiles.joined(spread(band, ranges(down, FEWEST_LINES, BANDS)))
        return self.source

    def _project(self, table, degree, factor, camera) -> None:
        """Fill the projected Gaussians, nearest first, and where each comes from."""

        def project(first: int, last: int):
            cut = slice(first, last)
            given = table[cut], degree, factor[cut], camera
            count, depth = projection.project(*given, self._rows[cut], self._source[cut])
            place = np.arange(first, first + count, dtype=np.int32)
            return depth[:count], place, self._source[place] + np.int32(first)

        made = spread(project, ranges(len(table), FEWEST, 1))
        depth, place, self.source = (np.concatenate(parts) for parts in zip(*made, strict=True))
        self.rows = np.empty((len(depth), projection.COLUMNS), self._rows.dtype)
        self.rank = np.empty(len(depth), np.int32)
        self._lines = np.empty((len(depth), 2), np.int16)
        given = tiles.by_depth(depth), place, self._rows, self.height
        arrange = partial(tiles.arrange, *given, self.rows, self.rank, self._lines)
        spread(arrange, ranges(len(depth), FEWEST, 1))

    def backward(self, table, degree, camera, gradient, grad, update=None) -> None:
        """Add the last drawing's gradients of the parameters to `grad`, from (3, h, w) of it, then
        call `update(first, last)`, if any, for ranges of the Gaussians seen."""
        (_, members), ends = self.tiles, np.empty(len(self.tiles[0]) - 1, np.int64)
        sums = np.zeros((len(self.rows), rasterize.SUMS), table.dtype)
        given = self.image, gradient, ends
        parts = ranges(len(ends), FEWEST_TILES, PARTS)
        apart = len(parts) > 1
        if apart and len(self._parts) < len(members):
            self._parts = np.empty((len(members), rasterize.SUMS), table.dtype)
        add_up = InOrder(partial(rasterize.add_up, *self.tiles, ends, self._parts, sums))

        def tiled(first: int, last: int) -> None:
            out = self._parts if apart else sums
            room = rasterize.room()
            rasterize.backward(self.rows, *self.tiles, room, *given, out, apart, first, last)
            if apart:  # sums are added in the order of the tiles, as on one thread
                add_up(first, last)

        spread(tiled, parts)

        def parameters(first: int, last: int) -> None:
            rank, source = self.rank[first:last], self.source[first:last]
            gradients.backward(table, degree, camera, self.rows, rank, source, sums, grad)
            if update is not None:
                update(first, last)

        spread(parameters, ranges(len(sums), FEWEST, 1))
