"""Reconstructors: each is bound to one capture and fits models to subsets of its frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from fsel.core.programs import MissingRequirement, NoDevice
from fsel.core.registry import Registry

if TYPE_CHECKING:  # the names alone import nothing
    import numpy as np

    from fsel.core.capture import Capture, Views


class Model(Protocol):
    """Result of a reconstructor: it renders, and says what it cost."""

    @property
    def primitives(self) -> int:
        """Number of splats, or of whatever else it is made of."""

    @property
    def bytes(self) -> int:
        """Size of its representation."""

    @property
    def seconds(self) -> float:
        """Spent fitting."""

    @property
    def peak_bytes(self) -> int:
        """The most memory that fitting took; see `fsel.reconstruct.configured.Peak`."""

    @property
    def device(self) -> str:
        """Device on which it was fitted, and renders: `cpu`, or a GPU's name."""

    def render(self, views: Views) -> np.ndarray:
        """Return (T, h, w, 3) float32 images in [0, 1]."""


class Reconstructor(Protocol):
    """Fits models to subsets of one capture's frames; caches what subsets share."""

    @property
    def capture(self) -> Capture:
        """Capture that it is bound to, at the reconstruction size."""

    def fit(self, frames: np.ndarray) -> Model:
        """Reconstruct from (K,) int64 distinct frames."""


class Factory(Protocol):
    """Binder of a reconstructor to a capture, with its settings as keywords: usually a class."""

    def __call__(self, capture: Capture, **settings: Any) -> Reconstructor:
        """Return the reconstructor of a capture that is at the reconstruction size."""

    def check(self, **settings: Any) -> None:
        """Ask for what it needs, before any work and without a capture.

        Raises:
            ValueError: for a setting that it does not take.
            ImportError, OSError: for a package, a device or weights that are not there, by name;
                or an ExceptionGroup of such.
        """


RECONSTRUCTORS: Registry[Factory] = Registry(
    "reconstructor",
    {
        "splats": "fsel.reconstruct.splats:Splats",
        "gaussians": "fsel.reconstruct.gaussians:Gaussians",
        "radiance_field": "fsel.reconstruct.radiance_field:RadianceField",
        "external": "fsel.reconstruct.external:External",
    },
    group="fsel.reconstructors",
)
"""By name. `check_needs` refuses one that cannot work here, with some settings."""

OWN = ("splats", "gaussians", "radiance_field")
"""Those that need nothing but this package; they work on a processor."""


def check_needs(reconstruction: Mapping[str, Any], devices: bool = True) -> None:
    """Refuse a configured reconstructor that cannot work here; nothing is fitted.

    Args:
        reconstruction: the config's section: name, settings.
        devices: whether GPUs must be here; on a cluster they are where the jobs run.

    Raises:
        ValueError: for an unknown name, or a setting that the reconstructor does not take.
        MissingRequirement: for a package, a device or weights that it needs and does not find.
    """
    name = reconstruction["name"]
    if name in OWN and not reconstruction["settings"]:
        return  # nothing to ask, and numba takes long to import
    lacking: Sequence[Exception] = []
    if name not in RECONSTRUCTORS:
        RECONSTRUCTORS.checked(name)  # refused in its own words, which name it
    try:
        RECONSTRUCTORS.checked(name).check(**reconstruction["settings"])
    except (ValueError, TypeError) as error:
        raise ValueError(f"reconstructor {name!r}: {error}") from error
    except (ImportError, OSError) as error:
        lacking = [error]
    except ExceptionGroup as group:
        lacking = group.exceptions
    if missing := [error for error in lacking if devices or not isinstance(error, NoDevice)]:
        said = "\n".join(map(str, missing))
        raise MissingRequirement(f"reconstructor {name!r}: {said}") from missing[0]


def needs_gpu(reconstruction: Mapping[str, Any]) -> bool:
    """Say whether a configured reconstructor works on a GPU; its factory's `needs_gpu` says so."""
    if reconstruction["name"] in OWN:
        return False
    declared = getattr(RECONSTRUCTORS.checked(reconstruction["name"]), "needs_gpu", None)
    return False if declared is None else bool(declared(**reconstruction["settings"]))


def reconstructor_of(capture: Capture, reconstruction: Mapping[str, Any]) -> Reconstructor:
    """Return the configured reconstructor, bound to the capture resized to its `long_side`."""
    factory = RECONSTRUCTORS.checked(reconstruction["name"])
    resized = capture.resized(reconstruction["long_side"])
    return factory(resized, **reconstruction["settings"])
