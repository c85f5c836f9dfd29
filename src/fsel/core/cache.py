"""The folder of the user's own that commands keep files in."""

from __future__ import annotations

import os
from pathlib import Path

ENVIRONMENT = "FSEL_CACHE"


def cache() -> Path:
    """Folder of found poses and fetched weights: FSEL_CACHE, else fsel in the user's cache."""
    own = os.environ.get(ENVIRONMENT)
    shared = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(own) if own else Path(shared) / "fsel"
