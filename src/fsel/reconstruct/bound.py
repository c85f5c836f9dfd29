"""Common parts: of reconstructors, a capture and checked settings; of models, what they cost."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar, Generic, TypeVar

from fsel.core.capture import Capture
from fsel.core.registry import settings_from
from fsel.reconstruct import gpu
from fsel.reconstruct.normalisation import Frame

Settings = TypeVar("Settings")


class Bound(Generic[Settings]):
    """A reconstructor bound to one capture; a subclass names its settings and fits.

    Args:
        capture: already at the reconstruction size.
        settings: keyword arguments of the subclass's dataclass of settings.

    Raises:
        ValueError: for an unknown setting, or one outside its range.
    """

    settings_type: ClassVar[type]

    def __init__(self, capture: Capture, **settings: Any) -> None:
        self.capture = capture
        self.settings: Settings = settings_from(self.settings_type, settings)

    @classmethod
    def check(cls, **settings: Any) -> None:
        """Refuse settings outside their range, and what they need and is not here.

        Raises: as `fsel.reconstruct.Factory.check`.
        """
        cls.check_requirements(settings_from(cls.settings_type, settings))

    @classmethod
    def check_requirements(cls, settings: Any) -> None:
        """Refuse what some settings need and is not here: a GPU, where they have it for a device.

        Raises:
            ImportError, OSError: by name; or an ExceptionGroup of such.
        """
        gpu.check(getattr(settings, "device", "cpu"))

    @classmethod
    def needs_gpu(cls, **settings: Any) -> bool:
        """Return whether it works on a GPU with some settings."""
        given = settings_from(cls.settings_type, settings)
        return getattr(given, "device", "cpu") == "cuda"


@dataclass(frozen=True)
class Fitted:
    """A model in coordinates of its own, and what it cost; a subclass adds what it is made of.

    Attributes:
        frame: where its origin and unit are in the world.
        seconds: spent fitting.
        peak_bytes: the most memory that fitting took, beyond what was cached; see `memory.Peak`.
        device: where it was fitted, and renders: `cpu`, or a GPU's name.
    """

    frame: Frame
    _: KW_ONLY
    seconds: float = 0.0
    peak_bytes: int = 0
    device: str = "cpu"
