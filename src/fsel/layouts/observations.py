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

from fsel.capture import MOST_LENGTH
from fsel.held import pycolmap
from fsel.layouts.base import RawPoints
from fsel.layouts.binary import IMAGES, POINTS, entries, is_binary, name_span

SIGHT = np.dtype([("xy", "<f8", 2), ("point", "<u8")])  # an entry of an image, as on disk
PLACE = np.dtype([("key", "<u8"), ("xyz", "<f8", 3), ("rgb", "u1", 3)])  # the start of a point
NO_POINT = 2**64 - 1  # of an observation that no point was made from


class Observed(NamedTuple):
    """A model's points, and what its images see of them.

    Attributes:
        places: (M,) of the dtype `PLACE`: ids, ascending, positions and colours of the points.
        sights: by an image's id, (n,) of the dtype `SIGHT`: pixels, and the id of a point or
            `NO_POINT`; read from disk when looked at.
        names: by an image's id.
    """

    places: np.ndarray
    sights: dict[int, np.ndarray]
    names: dict[int, str]


def observed(reconstruction: pycolmap.Reconstruction, model: Path | None = None) -> Observed:
    """What the images of a model that pycolmap has read see; of one without a pose, nothing.

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
    places = b"".join(content[at : at + PLACE.itemsize] for at in starts)
    sights, names = {}, {}
    content, starts = entries(model / IMAGES)
    for at in starts:
        (key,), (first, end) = unpack_from("<I", content, at), name_span(content, at)
        (count,) = unpack_from("<Q", content, end + 1)
        names[key] = content[first:end].decode()
        sights[key] = np.frombuffer(content, SIGHT, count, end + 1 + 8)
    return Observed(np.sort(np.frombuffer(places, PLACE), order="key"), sights, names)


def points_of(seen: Observed, rows: dict[int, int], source: str | Path) -> RawPoints | None:
    """Sparse points with their observations in the frames that `rows` numbers by image id.

    Raises:
        ValueError: naming the `source`, for numbers that are not finite, or an observation of a
            point that is not there.
    """
    places = seen.places
    if not len(places):
        return None
    sights, frame = _sights(seen, rows)
    point = np.searchsorted(places["key"], sights["point"])
    absent = places["key"][np.minimum(point, len(places) - 1)] != sights["point"]
    for row in np.flatnonzero(absent)[:1]:
        name = next(seen.names[image] for image, at in rows.items() if at == frame[row])
        key = sights["point"][row]
        raise ValueError(f"{source}: {name!r} observes point {key}, which is not there")
    _, first = np.unique(point * len(rows) + frame, return_index=True)  # one observation a frame
    xyz, xy = places["xyz"].copy(), sights["xy"]
    for row, _ in np.argwhere(~(np.abs(xyz) < MOST_LENGTH))[:1]:
        key = places["key"][row]
        raise ValueError(f"{source}: point {key} lies at {xyz[row].tolist()}, not finite")
    for row, _ in np.argwhere(~(np.abs(xy) < MOST_LENGTH))[:1]:
        key = sights["point"][row]
        raise ValueError(f"{source}: point {key} is seen at {xy[row].tolist()}")
    return RawPoints(
        xyz=xyz,
        rgb=places["rgb"].copy(),
        track_point=point[first],
        track_frame=frame[first],
        track_xy=xy[first],
    )


def _sights(seen: Observed, rows: dict[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """(L,) observations of points in the frames of `rows`, of the dtype `SIGHT`, and (L,) frames,
    ascending."""
    nothing = np.empty(0, SIGHT)
    found = [nothing]
    frames = [np.empty(0, np.int64)]
    for image, row in sorted(rows.items(), key=lambda item: item[1]):
        sights = seen.sights.get(image, nothing)
        found.append(sights[sights["point"] != NO_POINT])
        frames.append(np.full(len(found[-1]), row))
    return np.concatenate(found), np.concatenate(frames)
