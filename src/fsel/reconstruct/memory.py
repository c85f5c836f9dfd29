"""The most memory that a piece of work took."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import ClassVar
from weakref import WeakSet


class Peak:
    """Resident memory of this process at its highest, above what it held at the start.

    On Linux the kernel's own record is started anew; on macOS it cannot be, and only what goes
    beyond the process's highest so far is counted. On Windows nothing is counted. One may start
    while another is measured.
    """

    _measured: ClassVar[WeakSet[Peak]] = WeakSet()

    def __init__(self) -> None:
        self._most = 0
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
