"""Bounds on what is read and used, for readers and the command line: imports nothing slow."""

from __future__ import annotations

import os

MAX_ERROR = 0.02
"""Median reprojection or epipolar error, as a share of the images' longer side."""


def cores() -> int:
    """Return the processor cores that this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)  # Linux'
    return len(affinity(0)) if affinity else os.cpu_count() or 1
