"""Points and observations of a COLMAP model, as arrays.

pycolmap hands them out one by one: 600,000 took a second and a half. Its reader has checked the
model before: no id is there twice, every track leads to an observation.
"""

from __future__ import annotations

from pathlib import Path
from struct import unpack_from
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from fsel.captures.colmap.binary import IMAGES, POINTS, entries, is_binary, name_span
from fsel.captures.colmap.bindings import pycolmap
from fsel.core.geometry import MOST_LENGTH
from fsel.core.points import RawPoints

OBSERVATION = np.dtype([("xy", "<f8", 2), ("point", "<u8")])  # an entry of an image, as on disk
POINT = np.dtype([("key", "<u8"), ("xyz", "<f8", 3), ("rgb", "u1", 3), ("error", "<f8")])
"""The start of a point, as on disk."""
NO_POINT = 2**64 - 1  # of an observation that no point was made from


class Observed(NamedTuple):
    """A model's points, and what its images see of them.

    Attributes:
        points: (M,) of the dtype `POINT`: ids, ascending, positions, colours and errors.
        observations: by an image's id, (n,) of the dtype `OBSERVATION`: pixels, and the id of a
            point or `NO_POINT`; read from disk when looked at.
        names: by an image's id.
    """

    points: np.ndarray
    observations: dict[int, np.ndarray]
    names: dict[int, str]


def observed(reconstruction: pycolmap.Reconstruction, model: Path | None = None) -> Observed:
    """Observations of a model that pycolmap has read; an image without a pose has none.

    Args:
        reconstruction: the model.
        model: its folder. Where there is none, or its files are text, binary files are written
            first.
    """
    if model is not None and is_binary(model):
        return _read(model)
    with TemporaryDirectory() as folder:
        reconstruction.write_binary(folder)
        return _read(Path(folder))


def _read(model: Path) -> Observed:
    content, starts = entries(model / POINTS)
    points = b"".join(content[at : at + POINT.itemsize] for at in starts)
    observations, names = {}, {}
    content, starts = entries(model / IMAGES)
    for at in starts:
        (key,), (first, end) = unpack_from("<I", content, at), name_span(content, at)
        (count,) = unpack_from("<Q", content, end + 1)
        names[key] = content[first:end].decode()
        observations[key] = np.frombuffer(content, OBSERVATION, count, end + 1 + 8)
    return Observed(np.sort(np.frombuffer(points, POINT), order="key"), observations, names)


def points_of(seen: Observed, rows: dict[int, int], source: str | Path) -> RawPoints | None:
    """Sparse points with their observations in the frames that `rows` numbers by image id.

    Raises:
        ValueError: naming the `source`, for numbers that are not finite, or an observation of a
            point that is not there.
    """
    parts = (np.ascontiguousarray(seen.points[part]) for part in ("key", "xyz", "rgb", "error"))
    keys, xyz, rgb, error = parts
    if not len(keys):
        return None
    key, frame, xy = _observations(seen, rows)
    point = np.searchsorted(keys, key)
    absent = keys[np.minimum(point, len(keys) - 1)] != key
    for at in np.flatnonzero(absent)[:1]:
        name = next(seen.names[image] for image, row in rows.items() if row == frame[at])
        raise ValueError(f"{source}: {name!r} observes point {key[at]}, which is not there")
    for at, _ in np.argwhere(~(np.abs(xyz) < MOST_LENGTH))[:1]:
        raise ValueError(f"{source}: point {keys[at]} lies at {xyz[at].tolist()}, not finite")
    _, first = np.unique(point * len(rows) + frame, return_index=True)  # one observation a frame
    key, xy = key[first], xy[first]
    for at, _ in np.argwhere(~(np.abs(xy) < MOST_LENGTH))[:1]:
        raise ValueError(f"{source}: point {key[at]} is seen at {xy[at].tolist()}")
    return RawPoints(xyz, rgb, point[first], frame[first], track_xy=xy, error=error)


def _observations(
    seen: Observed, rows: dict[int, int]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(L,) ids of points, (L,) frames and (L, 2) pixels of observations, frame by frame."""
    nothing = np.empty(0, OBSERVATION)
    keys, frames, pixels = [nothing["point"]], [np.empty(0, np.int64)], [nothing["xy"]]
    for image, row in sorted(rows.items(), key=lambda item: item[1]):
        entries_of = seen.observations.get(image, nothing)
        made = entries_of["point"] != NO_POINT
        keys.append(entries_of["point"][made])
        frames.append(np.full(len(keys[-1]), row))
        pixels.append(entries_of["xy"][made])
    return np.concatenate(keys), np.concatenate(frames), np.concatenate(pixels)
