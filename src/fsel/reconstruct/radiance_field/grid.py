"""A sparse grid of vertices in the contracted cube."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
import scipy.ndimage

from fsel.core.compiled import exact
from fsel.core.threads import ranges, spread
from fsel.reconstruct.radiance_field.rays import HALF_SIDE, width_of

FEWEST = 4096  # vertices of a range


@dataclass(frozen=True)
class Grid:
    """A field at the vertices around the occupied cells; elsewhere space is empty."""

    side: int  # vertices along an edge of the cube
    occupied: np.ndarray  # (side**3,) bool, by the lowest vertex of a cell
    index: np.ndarray  # (side**3,) int32, the row of each vertex, or -1
    density: np.ndarray  # (n,) float32 logarithms of density, per contracted length
    color: np.ndarray  # (n, W) float32 raw: three channels for each harmonic, then padding
    harmonics: int

    @property
    def cells(self) -> np.ndarray:
        """(side, side, side) bool: occupied, by the lowest vertex."""
        return self.occupied.reshape((self.side,) * 3)

    @property
    def shape(self) -> tuple[float, int, np.ndarray]:
        """Arguments of `sample`: the length between samples, side, occupied."""
        return 2 * HALF_SIDE / (self.side - 1), self.side, self.occupied

    @property
    def field(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Arguments of `composite`: index, density, flat colour."""
        return self.index, self.density, self.color.reshape(-1)

    @property
    def bytes(self) -> int:
        """Memory of all arrays."""
        return sum(a.nbytes for a in (self.occupied, self.index, self.density, self.color))

    @classmethod
    def full(cls, side: int, density: float, color: np.ndarray, harmonics: int) -> Grid:
        """Return a grid of occupied cells, density and (3,) raw colour the same everywhere."""
        cells = np.zeros((side,) * 3, bool)
        cells[:-1, :-1, :-1] = True
        colors = np.zeros((side**3, width_of(harmonics)), np.float32)
        colors[:, :3] = color
        index = np.arange(side**3, dtype=np.int32)
        densities = np.full(side**3, density, np.float32)
        return cls(side, cells.reshape(-1), index, densities, colors, harmonics)

    def refined(self, kept: np.ndarray, side: int, empty: float) -> Grid:
        """Return the same field on a grid of `side` vertices along an edge, which covers the cells
        `kept`, with `empty` density at vertices that this grid lacks."""
        cells = _covered(kept, side)
        corners = np.ones((2, 2, 2), bool)
        places = np.flatnonzero(scipy.ndimage.binary_dilation(cells, corners, origin=-1))
        index = np.full(side**3, -1, np.int32)
        index[places] = np.arange(len(places), dtype=np.int32)
        density = np.empty(len(places), np.float32)
        color = np.empty((len(places), self.color.shape[1]), np.float32)
        old = (self.side, self.index, self.density, self.color)

        def resample(*cut: int) -> None:
            own = slice(*cut)
            _resample(places[own], side, *old, empty, density[own], color[own])

        spread(resample, ranges(len(places), FEWEST))
        return Grid(side, cells.reshape(-1), index, density, color, self.harmonics)

    def neighbours(self) -> np.ndarray:
        """Return (n, 3) int32 row of the next vertex along each axis, or -1."""
        index = self.index.reshape((self.side,) * 3)
        rows = np.full((len(self.density), 3), -1, np.int32)
        for axis in range(3):
            own = np.take(index, np.arange(self.side - 1), axis).reshape(-1)
            following = np.take(index, np.arange(1, self.side), axis).reshape(-1)
            rows[own[own >= 0], axis] = following[own >= 0]
        return rows


def grown(cells: np.ndarray) -> np.ndarray:
    """Return (s, s, s) cells and the 26 around each, by lowest vertex; the last is no cell."""
    out = scipy.ndimage.binary_dilation(cells, np.ones((3, 3, 3), bool))
    out[-1], out[:, -1], out[:, :, -1] = False, False, False
    return out


def _covered(kept: np.ndarray, side: int) -> np.ndarray:
    """Return (side, side, side) cells that share space with the kept cells of another grid."""
    old = len(kept) - 1
    first = np.arange(side - 1) * old // (side - 1)
    last = (np.arange(1, side) * old - 1) // (side - 1)
    cells = np.zeros((side,) * 3, bool)
    for a, b, c in product((first, last), repeat=3):
        cells[:-1, :-1, :-1] |= kept[np.ix_(a, b, c)]
    return cells


@exact
def _resample(places, side, old_side, index, density, color, empty, new_density, new_color):
    """Fill trilinear values at the vertices `places`; colours come from occupied ones."""
    ratio = (old_side - 1) / (side - 1)
    for n in range(len(places)):
        x, y, z = places[n] // (side * side), places[n] // side % side, places[n] % side
        u, v, w = x * ratio, y * ratio, z * ratio
        i, j, k = min(int(u), old_side - 2), min(int(v), old_side - 2), min(int(w), old_side - 2)
        total, value = 0.0, 0.0
        new_color[n] = 0
        for c in range(8):
            a, b, d = c >> 2, (c >> 1) & 1, c & 1
            row = index[((i + a) * old_side + j + b) * old_side + k + d]
            share = abs(1 - a - u + i) * abs(1 - b - v + j) * abs(1 - d - w + k)
            value += share * (density[row] if row >= 0 else empty)
            if row >= 0:
                total += share
                for m in range(color.shape[1]):
                    new_color[n, m] += share * color[row, m]
        new_density[n] = value
        for m in range(color.shape[1]):
            new_color[n, m] = new_color[n, m] / total if total > 0 else 0.0
