"""COLMAP models on disk: checked before COLMAP reads them, their points as arrays, and written.

COLMAP's reader takes anything beyond a file's end for counts, and pycolmap's observations are slow.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from mmap import ACCESS_READ, mmap
from pathlib import Path
from struct import error as Short
from struct import unpack_from
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from fsel.captures.colmap.camera import pycolmap
from fsel.captures.images.files import Size
from fsel.core.geometry import MOST_LENGTH
from fsel.core.points import RawPoints, by_key

CAMERAS, IMAGES, POINTS = "cameras.bin", "images.bin", "points3D.bin"
CAMERA = 4 + 4 + 8 + 8  # bytes of id, model, width, height
IMAGE = 4 + 7 * 8 + 4  # id, quaternion and translation, camera id
TRACK_ELEMENT = 4 + 4  # image id, index of the observation
OBSERVATION = np.dtype([("xy", "<f8", 2), ("point", "<u8")])  # an entry of an image
POINT = np.dtype([("key", "<u8"), ("xyz", "<f8", 3), ("rgb", "u1", 3), ("error", "<f8")])
"""The start of a point, as on disk."""
NO_POINT = 2**64 - 1  # of an observation that no point was made from


class Observed(NamedTuple):
    """A model's points, and what its images see of them, read from disk when looked at."""

    points: np.ndarray  # (M,) of the dtype `POINT`, ascending ids
    observations: dict[int, np.ndarray]  # by an image's id, (n,) of the dtype `OBSERVATION`
    names: dict[int, str]  # by an image's id


def check_whole(model: Path) -> None:
    """Refuse, by name, binary files that end before their counts say, or go on too long."""
    for path in sorted(model.glob("*.txt")) + sorted(model.glob("*.bin")):
        if not (path.is_file() or path.is_dir()):  # COLMAP's reader would wait, deaf to signals
            raise ValueError(f"{path}: not a regular file")
    for name in (CAMERAS, IMAGES, POINTS):
        if (model / name).is_file():
            _entries(model / name)


def is_binary(model: Path) -> bool:
    """Return whether COLMAP reads a folder's binary files, not its text."""
    return all((model / name).is_file() for name in (IMAGES, POINTS, CAMERAS))


def _entries(path: Path) -> tuple[mmap, list[int]]:
    """Return a binary file of cameras, images or points, and where each of its entries begins."""
    at, starts, kind = 8, [], path.name
    try:
        with path.open("rb") as file:
            content = mmap(file.fileno(), 0, access=ACCESS_READ)
        (count,) = unpack_from("<Q", content)
        for _ in range(count):
            starts.append(at)
            at = _end(content, at, kind)
            if at > len(content):  # before a later entry is looked for there
                raise ValueError(f"an entry ends at {at} of {len(content)} bytes")
        if at != len(content):
            raise ValueError(f"{len(content)} bytes, but its entries take {at}")
    except (Short, ValueError) as error:
        raise ValueError(f"{path}: cut short or damaged ({error})") from error
    return content, starts


def _end(content: mmap, at: int, kind: str) -> int:
    """Return where the entry ends that begins at `at` of a file of a kind."""
    if kind == CAMERAS:
        _, number = unpack_from("<ii", content, at)
        model = pycolmap.CameraModelId(number)  # ValueError for one that COLMAP has not
        camera = pycolmap.Camera.create_from_model_id(1, model, 1.0, 2, 2)
        return at + CAMERA + 8 * len(camera.params)
    if kind == IMAGES:
        at, each = _name_end(content, at) + 1, OBSERVATION.itemsize
    else:
        at, each = at + POINT.itemsize, TRACK_ELEMENT
    return at + 8 + each * unpack_from("<Q", content, at)[0]


def _name_end(content: mmap, at: int) -> int:
    """Return where the zero byte lies behind the name of the image that begins at `at`."""
    end = content.find(b"\0", at + IMAGE)
    if end < 0:
        raise ValueError(f"the name of the image at {at} is not terminated")
    return end


def points_reader(
    reconstruction: pycolmap.Reconstruction, ids: Sequence[int], model: Path | None = None
) -> Callable[[tuple[int, ...]], RawPoints | None]:
    """Return what reads the points of a model, see `RawCapture.points`; ids are of its images."""
    seen, source = cache(lambda: observed(reconstruction, model)), model or "the model"
    return cache(
        lambda rows: points_of(seen(), {ids[row]: at for at, row in enumerate(rows)}, source)
    )


def observed(reconstruction: pycolmap.Reconstruction, model: Path | None = None) -> Observed:
    """Return the observations of a model from its binary files, written if there are none."""
    with TemporaryDirectory() as folder:
        if model is None or not is_binary(model):
            reconstruction.write_binary(folder)
            model = Path(folder)
        content, starts = _entries(model / POINTS)
        rows, flat = np.array(starts, np.int64), np.frombuffer(content, np.uint8)
        points = np.stack([flat[rows + i] for i in range(POINT.itemsize)], 1).view(POINT).ravel()
        content, starts = _entries(model / IMAGES)
    observations, names = {}, {}
    for at in starts:
        (key,), end = unpack_from("<I", content, at), _name_end(content, at)
        (count,) = unpack_from("<Q", content, end + 1)
        names[key] = content[at + IMAGE : end].decode()
        observations[key] = np.frombuffer(content, OBSERVATION, count, end + 1 + 8)
    return Observed(points[np.argsort(points["key"], kind="stable")], observations, names)


def points_of(seen: Observed, rows: dict[int, int], source: str | Path) -> RawPoints | None:
    """Return sparse points as seen in frames that `rows` numbers by image id; refuse numbers not
    finite and observations of missing points."""
    parts = (np.ascontiguousarray(seen.points[part]) for part in ("key", "xyz", "rgb", "error"))
    keys, xyz, rgb, error = parts
    if not len(keys):
        return None
    nothing = np.empty(0, OBSERVATION)
    found, frames = [nothing], [np.empty(0, np.int64)]
    for image, row in sorted(rows.items(), key=lambda item: item[1]):
        entries = seen.observations.get(image, nothing)
        found.append(entries[entries["point"] != NO_POINT])
        frames.append(np.full(len(found[-1]), row))
    key, xy = (np.concatenate([entries[part] for entries in found]) for part in ("point", "xy"))
    frame = np.concatenate(frames)
    point = np.searchsorted(keys, key)
    absent = keys[np.minimum(point, len(keys) - 1)] != key
    for at in np.flatnonzero(absent)[:1]:
        name = next(seen.names[image] for image, row in rows.items() if row == frame[at])
        raise ValueError(f"{source}: {name!r} observes point {key[at]}, which is not there")
    for at, _ in np.argwhere(~(np.abs(xyz) < MOST_LENGTH))[:1]:
        raise ValueError(f"{source}: point {keys[at]} lies at {xyz[at].tolist()}, not finite")
    order, _ = by_key(point, len(keys))
    again = (np.diff(point[order]) == 0) & (np.diff(frame[order]) == 0)
    first = np.delete(order, np.flatnonzero(again) + 1)  # one observation a frame
    key, xy = key[first], xy[first]
    for at, _ in np.argwhere(~(np.abs(xy) < MOST_LENGTH))[:1]:
        raise ValueError(f"{source}: point {key[at]} is seen at {xy[at].tolist()}")
    return RawPoints(xyz, rgb, point[first], frame[first], track_xy=xy, error=error)


def build_model(
    names: Sequence[str],
    cameras: Sequence[pycolmap.Camera],
    world_to_camera: np.ndarray,
    xyz: np.ndarray,
    rgb: np.ndarray,
    seen: Sequence[np.ndarray],
    pixels: Sequence[np.ndarray],
    *,
    error: np.ndarray | None = None,
    ids: Sequence[int] | None = None,
    least: int = 0,
) -> pycolmap.Reconstruction:
    """Return a model of images and points.

    Args:
        names, cameras, world_to_camera: of n images; equal cameras become one.
        xyz, rgb: (M, 3) points, world units, and their colours, uint8.
        seen, pixels: n arrays, the points that each image sees, and (., 2) where it sees them.
        error: (M,) mean reprojection errors of the points, pixels; None where not known.
        ids: n distinct numbers of the images; None for 1 to n.
        least: images that must see a point, or it is left out.
    """
    model, numbers = pycolmap.Reconstruction(), dict[tuple, int]()
    tracks = [pycolmap.Track() for _ in xyz]
    ids = range(1, len(names) + 1) if ids is None else ids
    for i, camera in enumerate(cameras):
        key = (camera.model, camera.width, camera.height, *camera.params)
        if key not in numbers:
            camera.camera_id = numbers[key] = len(numbers) + 1
            model.add_camera_with_trivial_rig(camera)
        image = pycolmap.Image(
            image_id=ids[i], name=names[i], camera_id=numbers[key], keypoints=pixels[i]
        )
        model.add_image_with_trivial_frame(image, rigid_of(world_to_camera[i]))
        for at, point in enumerate(seen[i]):
            tracks[point].add_element(ids[i], at)
    for at, (point, track, color) in enumerate(zip(xyz, tracks, rgb, strict=True)):
        if track.length() >= least:
            key = model.add_point3D(point, track, color)
            if error is not None:
                model.points3D[key].error = error[at]
    return model


def enlarge(model: pycolmap.Reconstruction, sizes: Callable[[str], Size]) -> None:
    """Scale cameras and observations to the sizes, by name, of the images that were reduced."""
    reduced = {key: (camera.width, camera.height) for key, camera in model.cameras.items()}
    for image in model.images.values():
        size, before = sizes(image.name), reduced[image.camera_id]
        if size != before:
            model.cameras[image.camera_id].rescale(*size)
            for seen in image.points2D:
                seen.xy *= np.divide(size, before)
    model.update_point_3d_errors()


def rigid_of(pose: np.ndarray) -> pycolmap.Rigid3d:
    """Return a (3, 4) pose for pycolmap."""
    return pycolmap.Rigid3d(pycolmap.Rotation3d(pose[:, :3]), pose[:, 3])


def write_model(model: pycolmap.Reconstruction, folder: Path, *, text: bool = False) -> None:
    """Write a model's files into a folder, which is made where it is not there."""
    folder.mkdir(parents=True, exist_ok=True)
    (model.write_text if text else model.write_binary)(str(folder))


def write_capture_model(model: pycolmap.Reconstruction, folder: Path, cloud: Path) -> bool:
    """Write a model into `sparse/0` and its points, if any, as a `.ply`; return if it has any."""
    write_model(model, folder / "sparse" / "0")
    if model.points3D:
        model.export_PLY(str(cloud))
    return bool(model.points3D)
