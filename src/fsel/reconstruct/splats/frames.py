"""Data of single frames that matching needs: made when first needed, so that memory follows the
frames that are used and not those of the capture.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fsel.core.capture import Capture
from fsel.core.geometry import pixel_centers
from fsel.reconstruct.splats import stereo

FRAME_BYTES = 1 << 28  # of frames that are kept: 1,500 at 64x48


class Prepared(NamedTuple):
    """One frame.

    Attributes:
        image: (h, w, 3) float32 grey levels.
        grey: (h, w) float32, their mean.
        enlarged: (2h, 2w) uint64, see `stereo.packed`.
        rays: (2, h, w) float32, x/z and y/z of every pixel.
    """

    image: np.ndarray
    grey: np.ndarray
    enlarged: np.ndarray
    rays: np.ndarray


class Frames:
    """The frames of a capture, the oldest of which are forgotten."""

    def __init__(self, capture: Capture) -> None:
        self._capture = capture
        self._pixels = pixel_centers(*capture.size)
        self._known: dict[int, Prepared] = {}

    def __getitem__(self, frame: int) -> Prepared:
        if frame not in self._known:
            prepared = self._prepared(frame)
            make_room(self._known, FRAME_BYTES // sum(part.nbytes for part in prepared))
            self._known[frame] = prepared
        return self._known[frame]

    def _prepared(self, frame: int) -> Prepared:
        image = np.asarray(self._capture.images[frame]).astype(np.float32)
        (x, y), (fx, fy, cx, cy) = self._pixels, self._capture.intrinsics[frame]
        rays = np.stack([(x - cx) / fx, (y - cy) / fy]).astype(np.float32)
        return Prepared(image, image.mean(axis=-1), stereo.packed(image), rays)


def make_room(cache: dict, most: int) -> None:
    """Forget the oldest entry of a cache that holds `most`: dictionaries keep order."""
    if cache and len(cache) >= most:
        del cache[next(iter(cache))]
