"""Sparse points and their tracks, flat in memory and one row a point on disk."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np


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

    def seen_from(self, frames: np.ndarray, count: int) -> SparsePoints:
        """The same points as some frames see them, which are numbered in the given order.

        Args:
            frames: (n,) distinct frames.
            count: how many frames the tracks number.
        """
        place = np.full(count, -1)
        place[frames] = np.arange(len(frames))
        seen = place[self.track_frame] >= 0
        return replace(
            self,
            track_point=self.track_point[seen],
            track_frame=place[self.track_frame[seen]],
        )


def grouped_rows(keys: np.ndarray, count: int) -> list[np.ndarray]:
    """The rows of each key from 0 to `count` - 1, ascending: tracks by point, or by frame.

    Args:
        keys: (L,) int64, all below `count`.
        count: how many keys there are.
    """
    order = np.argsort(keys, kind="stable")
    bounds = np.searchsorted(keys[order], np.arange(count + 1))
    return [order[bounds[key] : bounds[key + 1]] for key in range(count)]


def points_columns(points: SparsePoints | None) -> dict[str, Any]:
    """One row a point; its track is the list of frames that saw it. No rows: no points."""
    if points is None:
        none = np.empty(0, np.int64)
        points = SparsePoints(np.empty((0, 3)), np.empty((0, 3), np.uint8), none, none)
    columns: dict[str, Any] = dict(zip("xyz", np.asarray(points.xyz).T, strict=True))
    columns |= dict(zip("rgb", np.asarray(points.rgb).T, strict=True))
    rows = grouped_rows(points.track_point, len(points.xyz))
    return columns | {"track": [points.track_frame[row] for row in rows]}


def points_from_columns(columns: Mapping[str, np.ndarray]) -> SparsePoints | None:
    """What `points_columns` made columns of."""
    tracks = columns["track"]
    if len(tracks) == 0:
        return None
    return SparsePoints(
        xyz=np.stack([columns[name] for name in "xyz"], axis=1).astype(np.float64),
        rgb=np.stack([columns[name] for name in "rgb"], axis=1).astype(np.uint8),
        track_point=np.repeat(np.arange(len(tracks)), [len(track) for track in tracks]),
        track_frame=np.concatenate(tracks).astype(np.int64),
    )
