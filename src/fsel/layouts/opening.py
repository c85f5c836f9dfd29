"""A capture opened for its poses: what its files say, with images left on disk until asked for."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fsel.capture import Capture
from fsel.layouts import read_raw
from fsel.layouts.base import RawCapture
from fsel.layouts.ingest import in_order, ingest
from fsel.layouts.previews import Progress, in_silence, in_turn

LONG_SIDE = 128  # pixels of the images that descriptors are made from
SAMPLE = 300  # frames whose points are read: a long capture has millions


@dataclass(frozen=True)
class Opened:
    """A capture and the files behind it, both in the capture's order of frames.

    Attributes:
        layout: what it was recognised as.
        raw: what the files say.
        capture: poses, and images that are opened when indexed.
    """

    layout: str
    raw: RawCapture
    capture: Capture

    @property
    def longest(self) -> int:
        """Pixels of the images' longer side, as the first camera states it."""
        return max(self.raw.cameras[0].width, self.raw.cameras[0].height)

    def loaded(self, frames: np.ndarray, progress: Progress = in_silence) -> Capture:
        """A capture of some frames alone, with their images in memory and the points they see.

        Args:
            frames: (n,) distinct frames, in the order they shall have.
            progress: wraps the loop over the images.
        """
        capture, points = self.capture, self.raw.subset(frames.tolist()).sparse()
        files = [self.raw.images[i] for i in frames]
        images = in_turn(lambda at: capture.images[frames[at]], files, progress)
        known = None if points is None else points.without_pixels()
        return replace(capture.subset(frames, np.stack(images)), points=known)

    def sample(self) -> tuple[np.ndarray, RawCapture]:
        """(m,) int64 frames, evenly drawn if many, and what the files say of them."""
        count = len(self.capture)
        drawn = np.linspace(0, count - 1, min(SAMPLE, count)).round().astype(np.int64)
        return drawn, self.raw.subset(drawn.tolist())

    def with_points(self) -> Capture:
        """The capture, its images unopened, with the points that a sample of its frames see."""
        drawn, raw = self.sample()
        points = raw.sparse()
        if points is None:
            return self.capture
        kept = points.without_pixels()
        return replace(self.capture, points=replace(kept, track_frame=drawn[kept.track_frame]))


def open_capture(path: str | Path, layout: str = "auto", long_side: int = LONG_SIDE) -> Opened:
    """Open a capture without opening its images.

    Args:
        path: its folder.
        layout: a key of `LAYOUTS`, or `auto` to recognise it.
        long_side: pixels of the longer side of images that are opened later.

    Raises:
        FileNotFoundError: when the folder or its model is not there.
        ValueError: for an unknown layout, or files that contradict themselves.
    """
    folder = Path(path)
    known, raw = read_raw(folder, layout)
    raw = in_order(raw, f"{known.name} at {folder}")
    return Opened(known.name, raw, ingest(raw, known, folder, long_side, lazy=True))
