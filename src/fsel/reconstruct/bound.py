"""Common part of all reconstructors: a capture, checked settings, and what the settings need."""

from __future__ import annotations

from typing import Any, ClassVar, Generic, TypeVar

from fsel.data.capture import Capture
from fsel.reconstruct import gpu
from fsel.utils.keywords import settings_from

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
