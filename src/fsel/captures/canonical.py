"""Canonical captures from raw files: order, checks, undistortion, resizing."""

from __future__ import annotations

import logging
import posixpath
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import cast

import cv2
import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.captures.colmap.undistortion import Lens, Lenses, common_frame
from fsel.captures.images import files as image_files
from fsel.captures.images.previews import in_turn
from fsel.captures.layouts.contract import RawCapture
from fsel.core.capture import Capture
from fsel.core.files import atomic, mapped_array
from fsel.core.geometry import check_poses, rigid
from fsel.core.names import natural

PROGRESS = 500  # frames between two lines in the log
LARGEST = 1 << 20  # pixels of an image's side
FOCAL = (1e-3, 1e4)  # least and greatest focal length, of an image's longer side
log = logging.getLogger(__name__)


def ingest(
    raw: RawCapture, source: str, long_side: int, *, lazy: bool = False, store: Path | None = None
) -> Capture:
    """Return a raw capture with every image opened, undistorted and resized, one by one.

    Args:
        source: what was read, in words.
        long_side: pixels of the longer side; smaller images keep their size.
        lazy: open images when indexed, each time anew, and leave masks and points out.
        store: folder that receives images.npy and masks.npy, so that memory holds one frame at a
            time; None keeps them in memory.
    """
    raw, points, masks = in_order(raw, source), None, None
    frame = common_frame(raw.cameras, long_side)
    if frame is not None:
        log.info("%s: cameras differ in shape: images are cropped to %dx%d", source, *frame)
    if lazy:
        frames, intrinsics = _unopened(raw, long_side, frame)
    else:
        points = raw.sparse()
        frames, intrinsics, masks = _opened(raw, source, Lenses(long_side, frame), store)
    return Capture(
        names=tuple(raw.names),
        world_to_camera=raw.world_to_camera,
        intrinsics=intrinsics,
        images=frames,
        sequences=tuple(raw.sequences),
        points=points.without_pixels() if points else None,
        masks=masks,
        source=source,
        files=raw,
    )


def in_order(raw: RawCapture, source: str) -> RawCapture:
    """Return the frames in natural order of their names, checked, with poses that are rotations."""
    twice = sorted(name for name, count in Counter(raw.names).items() if count > 1)
    if twice:
        raise ValueError(f"{source}: duplicate frame names {twice[:3]}")
    if not raw.names:
        raise ValueError(f"{source}: no frame remains; left out {len(raw.dropped)}")
    for name in raw.names:  # each stands on a line of a list, and leads to its file
        if not name.isprintable() or name != name.strip() or name != posixpath.normpath(name):
            raise ValueError(
                f"{source}: frame name {name!r} is not a plain path; allowed: no `.` or "
                "`..` between slashes, no control character, no space at either end"
            )
    if np.isnan(raw.world_to_camera).all():
        raise ValueError(
            f"{source}: images without poses. Hint: `poses: colmap` finds them, `poses: file` "
            "reads them from a COLMAP model"
        )
    raw = raw.subset(sorted(range(len(raw.names)), key=lambda i: natural(raw.names[i])))
    raw = replace(raw, world_to_camera=rigid(raw.world_to_camera))
    check_poses(raw.names, raw.world_to_camera, source)
    for camera, name in dict(zip(raw.cameras, raw.names, strict=True)).items():
        if not _possible(camera):
            raise ValueError(
                f"{source}: frame {name!r}: camera must have a positive size and focal length "
                f"({FOCAL[0]:g} to {FOCAL[1]:g} times the longer side) and finite parameters, got "
                f"{camera}"
            )
    return raw


def _possible(camera: Camera) -> bool:
    if not (0 < camera.width < LARGEST and 0 < camera.height < LARGEST):
        return False
    model = camera.colmap
    focal = np.array([model.focal_length_x, model.focal_length_y])
    share = focal / max(camera.width, camera.height)
    within = bool(((share >= FOCAL[0]) & (share <= FOCAL[1])).all())
    return within and bool(np.isfinite(camera.params).all())


def _opened(
    raw: RawCapture, source: str, lenses: Lenses, store: Path | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Images, (N, 4) intrinsics, and masks or None, all at the working size."""
    count, started = len(raw.names), time.perf_counter()
    intrinsics, sizes = [], []

    def lens_for(file: image_files.Image, at: int, image: np.ndarray) -> Lens:
        lens = lenses.of(raw.cameras[at], image, file)
        sizes.append(lens.size)
        check_same_size(file, lens.size, sizes[0])
        return lens

    def straight() -> Iterator[np.ndarray]:
        for i, file in enumerate(raw.images):
            image = image_files.load_for(file, lenses.long_side)
            lens = lens_for(file, i, image)
            intrinsics.append(lens.intrinsics)
            yield lens.straighten(image)
            if (i + 1) % PROGRESS == 0:
                rate = (i + 1) / (time.perf_counter() - started)
                log.info("%s: %d of %d frames, %.0f a second", source, i + 1, count, rate)

    def straight_masks() -> Iterator[np.ndarray]:
        for i, file in enumerate(raw.masks or ()):
            mask = image_files.load_mask(file, raw.mask_values)
            yield lens_for(file, i, mask).straighten_mask(mask)

    images = _stacked(straight(), count, store and store / "images.npy")
    if not raw.masks:
        return images, np.array(intrinsics), None
    masks = _stacked(straight_masks(), count, store and store / "masks.npy")
    return images, np.array(intrinsics), masks


def _stacked(items: Iterator[np.ndarray], count: int, path: Path | None) -> np.ndarray:
    """Return `count` arrays of one shape as one: in memory, or appended to a mapped .npy file."""
    if path is None:
        return np.stack(list(items))
    with atomic(path) as partial, partial.open("wb") as file:
        for item in items:
            if not file.tell():
                descr = np.lib.format.dtype_to_descr(item.dtype)
                shape = (count, *item.shape)
                header = {"descr": descr, "fortran_order": False, "shape": shape}
                np.lib.format.write_array_header_1_0(file, header)
            file.write(np.ascontiguousarray(item).data)
    return mapped_array(path)


def _unopened(
    raw: RawCapture, long_side: int, frame: tuple[int, int] | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return a lazy stack of images, and intrinsics at the size that the cameras state."""
    known = {}
    for camera in dict.fromkeys(raw.cameras):
        lens = Lens(camera, (camera.width, camera.height), long_side, frame)
        known[camera] = lens.intrinsics, lens.size
    size = known[raw.cameras[0]][1]
    for file, camera in zip(raw.images, raw.cameras, strict=True):
        check_same_size(file, known[camera][1], size)
    images = LazyImages(raw.images, raw.cameras, size, frame)
    intrinsics = np.array([known[camera][0] for camera in raw.cameras])
    return cast("np.ndarray", images), intrinsics  # it can do what `Capture` needs of one


class LazyImages:
    """A capture's images, opened, undistorted and resized when indexed: N files, a camera for each,
    and the (width, height) that all are brought to, or cropped to in a `frame`."""

    dtype = np.dtype(np.uint8)
    ndim = 4

    def __init__(
        self,
        files: Sequence[image_files.Image],
        cameras: list[Camera],
        size: tuple[int, int],
        frame: tuple[int, int] | None,
    ) -> None:
        self._files, self._cameras, self._size = files, cameras, size
        self._lenses = Lenses(max(size), frame)
        self.shape = (len(files), size[1], size[0], 3)

    def __len__(self) -> int:
        return len(self._files)

    def __getitem__(self, rows) -> np.ndarray:
        """Return (h, w, 3) for a number, (n, h, w, 3) for a slice or an array of numbers."""
        numbers = np.arange(len(self))[rows]
        if numbers.ndim == 0:
            return self._open(int(numbers))
        images = in_turn(lambda at: self._open(numbers[at]), [self._files[i] for i in numbers])
        return np.array(images, np.uint8).reshape(-1, *self.shape[1:])

    def __array__(self, dtype=None, copy=None) -> np.ndarray:
        return self[:] if dtype is None else self[:].astype(dtype)

    def _open(self, row: int) -> np.ndarray:
        file = self._files[row]
        image = image_files.load_for(file, self._lenses.long_side, approximate=True)
        lens = self._lenses.of(self._cameras[row], image, file)
        straight = lens.straighten(image)
        if lens.size == self._size:
            return straight
        # images smaller than their camera states, or reduced by a factor that is not whole
        return cv2.resize(straight, self._size, interpolation=cv2.INTER_AREA)


def check_same_size(file: image_files.Image, size: tuple[int, int], first: tuple[int, int]) -> None:
    """Refuse a file whose working size is not that of the first one."""
    if size != first:
        raise ValueError(
            f"{file}: {size} pixels after ingestion, others {first}; a capture's images and masks "
            "must share one size"
        )
