"""What the commands have in common."""

from __future__ import annotations

import argparse
from collections import Counter
from pathlib import Path

import numpy as np

from fsel.capture import Capture
from fsel.request.focus import Focus, from_box, from_masks


def focus_of(asked: argparse.Namespace, capture: Capture) -> Focus | None:
    """The object of `--masks` or `--box`."""
    if asked.masks is not None:
        return from_masks(capture, asked.masks)
    if asked.box is not None:
        return from_box(np.array(asked.box))
    return None


def inputs_of(asked: argparse.Namespace) -> list[Path]:
    """The files and folders that a command line names to be read."""
    named = [getattr(asked, name, None) for name in ("capture", "masks", "frames", "targets")]
    return [Path(name) for name in named if name is not None and Path(name).exists()]


def reasons(dropped: dict[str, str]) -> str:
    """Why frames were left out, and how many for each reason."""
    return ", ".join(f"{reason} ({count})" for reason, count in Counter(dropped.values()).items())
