"""A capture opened for its poses; its images are left on disk until they are indexed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fsel.captures.canonical import in_order, ingest
from fsel.captures.colmap.undistortion import pinhole_of
from fsel.captures.images.files import is_there
from fsel.captures.images.previews import Progress, in_silence, in_turn
from fsel.captures.layouts.contract import Layout, RawCapture
from fsel.captures.poses.agreement import NOT_MEASURED, Agreement
from fsel.captures.read import read_posed, sample, validated
from fsel.core.capture import Capture
from fsel.core.limits import MAX_ERROR
from fsel.core.points import RawPoints
from fsel.core.wording import check_type

LONG_SIDE = 128  # pixels of the images that descriptors are made from


class NoImages:
    """Images of a capture that has none: their number and (width, height) alone are known."""

    dtype, ndim = np.dtype(np.uint8), 4

    def __init__(self, count: int, size: tuple[int, int]) -> None:
        self.shape = (count, size[1], size[0], 3)

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, rows: object) -> np.ndarray:
        raise ValueError(
            "the capture has poses but no images, which are needed here. Hint: give its folder, or "
            "run where its images are"
        )


@dataclass(frozen=True)
class LazyCapture:
    """A capture and the files behind it, both in the capture's order of frames."""

    layout: str  # what it was recognised as
    raw: RawCapture  # what the files say
    capture: Capture  # poses, and images that are opened when indexed
    agreement: Agreement = NOT_MEASURED
    skipped: dict[str, str] = field(default_factory=dict)  # unreadable frames, with the fault
    found: dict | None = None  # what `placement.place` said of a video or photos

    @property
    def longest(self) -> int:
        """Return the pixels of the images' longer side, as the first camera states it."""
        return max(self.raw.cameras[0].width, self.raw.cameras[0].height)

    @property
    def pictured(self) -> bool:
        """Return whether the capture has images."""
        return not isinstance(self.capture.images, NoImages)

    @cached_property
    def points(self) -> RawPoints | None:
        """The points that its frames see, with their pixels; read once."""
        return self.raw.sparse()

    @property
    def seconds(self) -> np.ndarray | None:
        """Return the (N,) seconds of frames of videos, NaN of others; None without a video."""
        known = {shot["name"]: shot["seconds"] for shot in (self.found or {}).get("video", ())}
        names = self.capture.names
        return np.array([known.get(name, np.nan) for name in names]) if known else None

    @property
    def left_out(self) -> dict[str, str]:
        """Frames that the capture names and cannot use, with the reason, but for `skipped`."""
        gone = self.raw.dropped.items()
        return {name: why for name, why in gone if name not in self.skipped}

    def loaded(self, frames: np.ndarray, progress: Progress = in_silence) -> Capture:
        """A capture of (n,) distinct frames, with images in memory and the points that they see."""
        raw = self.raw.subset(frames.tolist())
        images = in_turn(lambda at: self.capture.images[frames[at]], raw.images, progress)
        points, kept = raw.sparse(), self.capture.subset(frames, np.stack(images))
        return replace(kept, points=points and points.without_pixels())

    def part(self, frames: np.ndarray) -> LazyCapture:
        """Return (n,) ascending frames as a capture; points are read once for all parts."""

        def points(rows: tuple[int, ...]) -> RawPoints | None:
            if self.points is None:
                return None
            seen = self.points.seen_from(frames[list(rows)], len(self.raw.names))
            return seen.subset(np.bincount(seen.track_point, minlength=len(seen.xyz)) > 0)

        raw = replace(self.raw.subset(frames.tolist()), dropped={}, points=points)
        capture = ingest(raw, self.capture.source, LONG_SIDE, lazy=True)
        return replace(self, raw=raw, capture=capture)

    def with_all_points(self) -> Capture:
        """Return the capture, its images unopened, with the points that its frames see."""
        return replace(self.capture, points=self.points and self.points.without_pixels())

    def with_points(self) -> Capture:
        """Return the same with the points that a sample of its frames see."""
        drawn, raw = sample(self.raw)
        points = raw.sparse()
        if points is None:
            return self.capture
        kept = points.without_pixels()
        return replace(self.capture, points=replace(kept, track_frame=drawn[kept.track_frame]))


def of_capture(capture: Capture) -> LazyCapture | None:
    """Return a capture with the files that it was read from; None where none is there."""
    layout, raw = capture.source.partition(" at ")[0], capture.files
    there = raw is not None and any(map(is_there, raw.images))
    return LazyCapture(layout, raw, capture) if there else None


def open_capture(
    path: str | Path,
    layout: str = "auto",
    long_side: int = LONG_SIDE,
    max_error: float = MAX_ERROR,
    *,
    skip_unreadable: bool = False,
    **posing: Any,
) -> LazyCapture:
    """Open a capture without its images; arguments and errors are those of `read_folder`, `posing`
    `poses`, `model`, `every` and `reading` of them."""
    check_type("path", path, (str, Path), "a folder")
    folder = Path(path)
    known, raw = read_posed(folder, layout, **posing)
    return opened(known, raw, folder, long_side, max_error, skip_unreadable=skip_unreadable)


def opened(
    known: Layout,
    raw: RawCapture,
    folder: Path,
    long_side: int = LONG_SIDE,
    max_error: float = MAX_ERROR,
    *,
    skip_unreadable: bool = False,
) -> LazyCapture:
    """Open what a layout's reader returned; other arguments and errors as of `open_capture`."""
    gone, source = raw.dropped, f"{known.name} at {folder}"
    raw, agreement = validated(raw, source, long_side, max_error, skip_unreadable=skip_unreadable)
    capture = replace(ingest(raw, source, long_side, lazy=True), files=raw)
    skipped = {name: why for name, why in raw.dropped.items() if name not in gone}
    return LazyCapture(known.name, raw, capture, agreement, skipped)


def posed(name: str, raw: RawCapture) -> LazyCapture:
    """Return a capture of poses and points alone; its images are not there."""
    source = f"the given {name}"
    raw = in_order(raw, source)
    size = (raw.cameras[0].width, raw.cameras[0].height)
    scales = [np.tile(np.divide(size, (c.width, c.height)), 2) for c in raw.cameras]
    pinholes = [pinhole_of(camera.colmap) for camera in raw.cameras]
    images: Any = NoImages(len(raw.names), size)
    poses, intrinsics = raw.world_to_camera, np.array(scales) * pinholes
    names, passes = tuple(raw.names), tuple(raw.sequences)
    capture = Capture(names, poses, intrinsics, images, passes, source=source)
    return LazyCapture(name, raw, capture)
