"""Reconstructors: each is bound to one capture and fits models to subsets of its frames."""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import ModuleType
from typing import Protocol

import numpy as np

from fsel.capture import Capture, Views
from fsel.reconstruct.splats import Splats


class Model(Protocol):
    """What a reconstructor returns: it renders, and says what it cost."""

    primitives: int
    bytes: int
    seconds: float

    def render(self, views: Views) -> np.ndarray:
        """(T, h, w, 3) float32 images in [0, 1]."""


class Reconstructor(Protocol):
    """Fits models to subsets of one capture's frames; caches what subsets share."""

    capture: Capture

    def fit(self, frames: np.ndarray) -> Model:
        """Reconstruct from (K,) int64 distinct frames."""


RECONSTRUCTORS: dict[str, Callable[..., Reconstructor]] = {"splats": Splats}
"""By name: `factory(capture, **settings)`, the capture being at the reconstruction size."""


def reconstruct(
    capture: Capture, frames: np.ndarray, reconstructor: str = "splats", **settings
) -> Model:
    """Reconstruct a scene from some frames of a capture.

    Args:
        capture: at the size to reconstruct at: the `long_side` of `fsel.read_capture`.
        frames: numbers of two or more distinct frames.
        reconstructor: a key of `RECONSTRUCTORS`.
        settings: of the reconstructor.

    Returns:
        A model: `render(views)` gives (T, h, w, 3) float32 images, `export_ply(path)` writes
        standard Gaussian splats.

    Raises:
        ValueError: for an unknown reconstructor, fewer than two frames, or repeated ones.
    """
    if reconstructor not in RECONSTRUCTORS:
        raise ValueError(
            f"reconstructor is {reconstructor!r}; allowed: {', '.join(RECONSTRUCTORS)}"
        )
    return RECONSTRUCTORS[reconstructor](capture, **settings).fit(np.asarray(frames, np.int64))


class _Callable(ModuleType):
    """`fsel.reconstruct` is this package; calling it reconstructs."""

    __call__ = staticmethod(reconstruct)


sys.modules[__name__].__class__ = _Callable
