"""Bounds on what is read and used, for readers and the command line: imports nothing slow."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path

MAX_ERROR = 0.02
"""Median reprojection or epipolar error, as a share of the images' longer side."""

WHEN_COMPILED: list[Callable[[float], None]] = []
"""Called with the seconds that a function took, each time that one has been compiled."""

THREADS = "FSEL_THREADS"
QUOTA = Path("/sys/fs/cgroup/cpu.max")  # of a container: microseconds of a period, or max


def cores() -> int:
    """Return the processor cores that this process may use, by affinity mask and quota."""
    affinity = getattr(os, "sched_getaffinity", None)  # Linux'
    allowed = len(affinity(0)) if affinity else os.cpu_count() or 1
    return int(min(allowed, quota(QUOTA)))


@cache
def quota(path: Path) -> float:
    """Return the cores of a container's quota, rounded up; infinite where there is none."""
    share, period = (path.read_text() if path.is_file() else "max 1").split()
    return math.inf if share == "max" else max(math.ceil(int(share) / int(period)), 1)


def threads() -> int:
    """Return how many threads to work on: `FSEL_THREADS`, `OMP_NUM_THREADS`, or all cores."""
    text, common = os.environ.get(THREADS, ""), os.environ.get("OMP_NUM_THREADS", "")
    if text and not (text.isdecimal() and int(text)):
        raise ValueError(f"{THREADS} is {text!r}; allowed: a whole number, 1 or more")
    return int(text or 0) or int(common if common.isdecimal() else 0) or cores()


def set_threads(count: int | None) -> None:
    """Set how many threads this process, and those it starts, work on; None for the default.

    Example:
        >>> fsel.set_threads(2)
    """
    if count is not None and (type(count) is not int or count < 1):
        raise ValueError(f"threads is {count!r}; allowed: a whole number, 1 or more, or None")
    os.environ[THREADS] = str(count or "")
