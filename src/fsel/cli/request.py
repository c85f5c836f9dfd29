"""Arguments that commands have in common: inputs, targets, an object."""

from __future__ import annotations

import argparse
from collections import Counter
from pathlib import Path

import numpy as np

from fsel.captures.lazy import LazyCapture
from fsel.core.capture import Capture
from fsel.core.wording import counted
from fsel.selection.focus import (
    Focus,
    boxed,
    check_within,
    from_box,
    from_masks,
    masked,
    scene_bounds,
)


def focus_of(args: argparse.Namespace, opened: LazyCapture) -> Focus | None:
    """The object of `--masks` or `--box`; a box outside of the scene is refused."""
    if args.masks is not None:
        return from_masks(opened.capture, args.masks)
    if args.box is not None:
        box = from_box(np.array(args.box))
        check_within(box, scene_bounds(opened.with_points()))
        return box
    return None


def outlines(
    args: argparse.Namespace, capture: Capture, frames: np.ndarray, focus: Focus | None
) -> tuple[np.ndarray, np.ndarray | None]:
    """The frames that show the object of `--masks` or `--box`, and (n, h, w) where; or all, None.

    Raises:
        ValueError: when none of the frames shows it.
    """
    if focus is None:
        return frames, None
    from fsel.metrics import inside  # here: numba takes longer to import than a selection takes

    if args.masks is not None:
        shown = masked(capture, frames, args.masks)
    else:
        shown = boxed(capture, frames, focus)
    kept = inside(shown) > 0
    if not kept.any():
        raise ValueError(
            f"none of {counted(len(frames), 'held-out frame')} shows the object ({focus.kind}): "
            "there is nothing to compare. Hint: hold out other frames with --targets"
        )
    return frames[kept], shown[kept]


def inputs_of(args: argparse.Namespace) -> list[Path]:
    """The files and folders that a command line names to be read."""
    names = ("capture", "masks", "frames", "targets", "weights", "always", "never")
    named = [*(getattr(args, name, None) for name in names), *getattr(args, "beside", ())]
    return [Path(name) for name in named if name is not None and Path(name).exists()]


def reasons(dropped: dict[str, str]) -> str:
    """Reasons why frames were left out, and how many for each."""
    return ", ".join(f"{reason} ({count})" for reason, count in Counter(dropped.values()).items())
