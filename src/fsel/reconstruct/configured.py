"""Common parts: of reconstructors, a capture and checked settings; of models, what they cost."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from threading import Lock
from typing import Any, ClassVar, Generic, TypeVar
from weakref import WeakSet

from fsel.core.capture import Capture
from fsel.core.registry import settings_from
from fsel.reconstruct.selected import Frame

Settings = TypeVar("Settings")


class ConfiguredReconstructor(Generic[Settings]):
    """A reconstructor of one capture with checked settings; a subclass names them and fits.

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
        """Refuse settings as `fsel.reconstruct.Factory.check` does."""
        settings_from(cls.settings_type, settings)


def check_integer(name: str, value: Any, least: int, most: float = math.inf) -> None:
    """Refuse a setting that is no integer of a range, by name."""
    whole = isinstance(value, int) and not isinstance(value, bool)
    if not whole or not least <= value <= most:
        allowed = f"from {least}" + (f" to {most}" if most < math.inf else "")
        raise ValueError(f"{name} must be an integer {allowed}, got {value!r}")


def check_number(name: str, value: Any, allowed: str, holds: Callable[[float], bool]) -> None:
    """Refuse a setting that is no finite number, or one that something does not hold of."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number or not math.isfinite(value) or not holds(value):
        raise ValueError(f"{name} must be {allowed}, got {value!r}")


@dataclass(frozen=True)
class Fitted:
    """A model in coordinates of its own, and what it cost; see `fsel.reconstruct.Model`."""

    frame: Frame
    _: KW_ONLY
    seconds: float = 0.0
    peak_bytes: int = 0
    device: str = "cpu"


class Peak:
    """Resident memory of this process at its highest, above that at the start.

    One may start while another is measured. On macOS, which cannot forget the highest so far, only
    what goes beyond it is counted; on Windows nothing is.
    """

    _measured: ClassVar[WeakSet[Peak]] = WeakSet()
    _lock: ClassVar[Lock] = Lock()

    def __init__(self) -> None:
        self._most = 0
        with self._lock:
            for other in self._measured:  # the record that they go by is about to be forgotten
                other._most = max(other._most, _highest())
            try:
                Path("/proc/self/clear_refs").write_text("5")  # forget the highest so far
            except OSError:
                self._start = _highest()
            else:
                self._start = _resident("VmRSS")
            self._measured.add(self)

    @property
    def bytes(self) -> int:
        """Largest number of bytes added since the start."""
        return max(self._most - self._start, _highest() - self._start, 0)


def _highest() -> int:
    if sys.platform == "linux":
        return _resident("VmHWM")
    try:
        import resource
    except ImportError:  # Windows
        return 0
    largest = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return largest if sys.platform == "darwin" else largest * 1024


def _resident(field: str) -> int:
    matches = re.findall(rf"{field}:\s+(\d+) kB", Path("/proc/self/status").read_text())
    return int(matches[0]) * 1024
