"""A capture opened for its poses: what its files say, with images left on disk until asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fsel.capture import Capture, SparsePoints
from fsel.glance import Progress, in_parallel, in_silence
from fsel.layouts import read_raw
from fsel.layouts.base import RawPoints
from fsel.layouts.ingest import in_order, ingest
from fsel.recording import Camera

LONG_SIDE = 128  # pixels of the images that descriptors are made from


@dataclass(frozen=True)
class Opened:
    """A capture and the files behind it, all in the capture's order of frames.

    Attributes:
        folder: where it lies.
        layout: what it was recognised as.
        capture: poses, and images that are opened when indexed.
        files: N image files.
        cameras: N cameras, at the size that the capture's files state.
        dropped: frames left out, and why.
    """

    folder: Path
    layout: str
    capture: Capture
    files: Sequence[Path]
    cameras: Sequence[Camera]
    dropped: dict[str, str]
    _points: object

    @property
    def longest(self) -> int:
        """Pixels of the images' longer side, as the first camera states it."""
        return max(self.cameras[0].width, self.cameras[0].height)

    def points(self) -> RawPoints | None:
        """Sparse points with tracks over the capture's frames; None where there are none."""
        return self._points()

    def loaded(self, frames: np.ndarray, progress: Progress = in_silence) -> Capture:
        """A capture of some frames alone, with their images in memory and the points they see.

        Args:
            frames: (n,) distinct frames, in the order they shall have.
            progress: wraps the loop over the images.
        """
        capture, points = self.capture, self.points()
        images = in_parallel(capture.images.__getitem__, frames.tolist(), progress)
        position = np.full(len(capture), -1)
        position[frames] = np.arange(len(frames))
        if points is not None:
            track = position[points.track_frame]
            points = SparsePoints(
                points.xyz, points.rgb, points.track_point[track >= 0], track[track >= 0]
            )
        return replace(
            capture,
            names=tuple(capture.names[i] for i in frames),
            world_to_camera=capture.world_to_camera[frames],
            intrinsics=capture.intrinsics[frames],
            images=np.stack(images),
            sequences=tuple(capture.sequences[i] for i in frames),
            points=points,
        )


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
    return Opened(
        folder=folder,
        layout=known.name,
        capture=ingest(raw, known, folder, long_side, lazy=True),
        files=raw.images,
        cameras=raw.cameras,
        dropped=raw.dropped,
        _points=raw.sparse,
    )
