"""Sparse points and their tracks, flat in memory and one row a point on disk."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from fsel.core.files import Columns

LARGE = 200  # values of a key, from which on those of each are sorted apart


@dataclass(frozen=True)
class SparsePoints:
    """Structure-from-motion points with their tracks.

    Attributes:
        xyz: (M, 3) float64, world units.
        rgb: (M, 3) uint8.
        track_point: (L,) int64, index into `xyz` of each observation.
        track_frame: (L,) int64, index of the observing frame.
    """

    xyz: np.ndarray
    rgb: np.ndarray
    track_point: np.ndarray
    track_frame: np.ndarray

    def observed(self, rows: np.ndarray) -> Self:
        """Return the same points with some of the observations, by number or (L,) bool."""
        return replace(self, track_point=self.track_point[rows], track_frame=self.track_frame[rows])

    def seen_from(self, frames: np.ndarray, count: int) -> Self:
        """Return the same points as (n,) distinct of `count` frames, numbered anew, see them."""
        place = np.full(count, -1)
        place[frames] = np.arange(len(frames))
        seen = self.observed(place[self.track_frame] >= 0)
        return replace(seen, track_frame=place[seen.track_frame])


def grouped_rows(keys: np.ndarray, count: int) -> list[np.ndarray]:
    """Return the rows, ascending, of each of `count` keys, given (L,) int64 keys from 0."""
    order, bounds = by_key(keys, count)
    return [order[bounds[key] : bounds[key + 1]] for key in range(count)]


def by_key(keys: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the (L,) rows of keys in order, and where those of each of `count` begin and end."""
    # two bytes at a time, which NumPy sorts by radix, up to five times as fast
    order = np.argsort(keys.astype(np.uint16), kind="stable")
    for shift in range(16, int(count).bit_length(), 16):
        order = order[np.argsort((keys[order] >> shift).astype(np.uint16), kind="stable")]
    return order, np.append(0, np.bincount(keys, minlength=count).cumsum())


def quantile_of(values: np.ndarray, keys: np.ndarray, count: int, share: float) -> np.ndarray:
    """Return the (count,) lower quantile, 0 to 1, of the (L,) values of each of (L,) keys; NaN for
    a key without any."""
    order, bounds = by_key(keys, count)
    size, found = np.diff(bounds), np.full(count, np.nan)
    place = (share * np.maximum(size - 1, 0)).astype(np.int64)
    if len(values) > LARGE * count:
        for key in np.flatnonzero(size):
            own = values[order[bounds[key] : bounds[key + 1]]]
            found[key] = np.partition(own, place[key])[place[key]]
        return found
    ascending = np.argsort(values)
    order = ascending[by_key(keys[ascending], count)[0]]
    found[size > 0] = values[order[(bounds[:-1] + place)[size > 0]]]
    return found


def points_table(points: SparsePoints | None) -> dict[str, Any]:
    """Return one row a point, with its track, the list of frames that saw it; none, no rows."""
    if points is None:
        return {name: np.empty(0) for name in ("x", "y", "z", "r", "g", "b", "track")}
    rows = grouped_rows(points.track_point, len(points.xyz))
    table = dict(zip("xyz", np.asarray(points.xyz).T, strict=True))
    table |= zip("rgb", np.asarray(points.rgb).T, strict=True)
    return {**table, "track": [points.track_frame[row] for row in rows]}


def points_from_table(table: Columns) -> SparsePoints | None:
    """Return the points of a table that `points_table` made."""
    if not len(table["x"]):
        return None
    lengths = [len(track) for track in table["track"]]
    return SparsePoints(
        xyz=np.array([table[name] for name in "xyz"], np.float64).T,
        rgb=np.array([table[name] for name in "rgb"], np.uint8).T,
        track_point=np.repeat(np.arange(len(lengths)), lengths),
        track_frame=np.concatenate(list(table["track"])).astype(np.int64),
    )


@dataclass(frozen=True)
class RawPoints(SparsePoints):
    """Sparse points as a raw capture has them: its order numbers the frames.

    Attributes:
        track_xy: (L, 2) float64, pixels in the frame as its camera states it, distorted.
        error: (M,) float64 mean reprojection errors, pixels, -1 where not known; None for nowhere.
    """

    track_xy: np.ndarray
    error: np.ndarray | None = None

    def observed(self, rows: np.ndarray) -> Self:
        return replace(super().observed(rows), track_xy=self.track_xy[rows])

    def subset(self, chosen: np.ndarray) -> Self:
        """Return some of the points, (M,) bool, with their observations."""
        seen = self.observed(chosen[self.track_point])
        return replace(
            seen,
            xyz=self.xyz[chosen],
            rgb=self.rgb[chosen],
            track_point=(np.cumsum(chosen) - 1)[seen.track_point],
            error=None if self.error is None else self.error[chosen],
        )

    def without_pixels(self) -> SparsePoints:
        """Return the points without the places in the images that they were seen at."""
        return SparsePoints(self.xyz, self.rgb, self.track_point, self.track_frame)


NO_POINTS = RawPoints(
    xyz=np.empty((0, 3)),
    rgb=np.empty((0, 3), np.uint8),
    track_point=np.empty(0, np.int64),
    track_frame=np.empty(0, np.int64),
    track_xy=np.empty((0, 2)),
)
