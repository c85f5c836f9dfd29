"""Reconstructors: each is bound to one capture and fits models to subsets of its frames."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np

from fsel.capture import Capture, Views
from fsel.registry import Registry


class Model(Protocol):
    """What a reconstructor returns: it renders, and says what it cost."""

    @property
    def primitives(self) -> int:
        """How many splats, or whatever else it is made of."""

    @property
    def bytes(self) -> int:
        """Size of its representation."""

    @property
    def seconds(self) -> float:
        """Spent fitting."""

    def render(self, views: Views) -> np.ndarray:
        """(T, h, w, 3) float32 images in [0, 1]."""


class Reconstructor(Protocol):
    """Fits models to subsets of one capture's frames; caches what subsets share."""

    @property
    def capture(self) -> Capture:
        """What it is bound to, at the reconstruction size."""

    def fit(self, frames: np.ndarray) -> Model:
        """Reconstruct from (K,) int64 distinct frames."""


RECONSTRUCTORS: Registry[Callable[..., Reconstructor]] = Registry(
    "reconstructor",
    {
        "splats": "fsel.reconstruct.splats:Splats",
        "gaussians": "fsel.reconstruct.gaussians:Gaussians",
        "radiance_field": "fsel.reconstruct.radiance_field:RadianceField",
    },
)
"""By name: `factory(capture, **settings)`, the capture being at the reconstruction size.

A factory refuses by name what it needs and does not find: settings, a device, weights.
"""


def reconstructor_of(capture: Capture, reconstruction: Mapping[str, Any]) -> Reconstructor:
    """The configured reconstructor, bound to the capture at the reconstruction's size.

    Args:
        capture: the capture, at any size.
        reconstruction: the config's section: name, long_side, settings.
    """
    factory = RECONSTRUCTORS[reconstruction["name"]]
    resized = capture.resized(reconstruction["long_side"])
    return factory(resized, **reconstruction["settings"])
