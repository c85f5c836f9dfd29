"""Validation of a capture, whether `read_capture` or a command reads it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from fsel.captures.canonical import check_same_size, in_order
from fsel.captures.colmap.undistortion import common_frame, working_size
from fsel.captures.images import files as image_files
from fsel.captures.images.previews import in_turn
from fsel.captures.layouts.contract import RawCapture
from fsel.captures.poses.agreement import Agreement, measure
from fsel.core.limits import MAX_ERROR
from fsel.core.subsets import evenly
from fsel.core.wording import counted

SAMPLE = 300  # frames whose points are read: a long capture has millions


def validated(
    raw: RawCapture,
    source: str,
    long_side: int,
    max_error: float = MAX_ERROR,
    *,
    skip_unreadable: bool = False,
) -> tuple[RawCapture, Agreement]:
    """A capture's frames in natural order, and how well their parts agree.

    Every image's header is read. Pixels are decoded only where poses have no points to agree with,
    or where `skip_unreadable` asks which can be.

    Args:
        raw: what a layout's reader returned.
        source: what was read, in words.
        long_side: pixels of the longer side that images will be brought to.
        max_error: greatest median disagreement of poses and images, as a share of the images'
            longer side.
        skip_unreadable: leave out frames whose image or mask is missing or unreadable, in place of
            refusing them.

    Raises:
        ValueError: for what `in_order` refuses, an image that is missing, damaged, too large or
            of another shape than its camera, images of several sizes, or poses that disagree with
            points or images.
    """
    raw = in_order(raw, source)
    if skip_unreadable:
        raw = _readable(raw, source)
    check_images(raw, long_side)
    return raw, _agreeing(raw, source, max_error)


def sample(raw: RawCapture) -> tuple[np.ndarray, RawCapture]:
    """(m,) int64 frames, evenly drawn if many, and what the files say of them."""
    drawn = evenly(len(raw.names), SAMPLE)
    return drawn, raw.subset(drawn.tolist())


def _readable(raw: RawCapture, source: str) -> RawCapture:
    """The frames whose image and mask can be opened; the others are dropped, each with its fault.

    Raises:
        ValueError: when none is left.
    """
    faults = _faults(raw.images)
    if raw.masks:
        faults = [one or other for one, other in zip(faults, _faults(raw.masks), strict=True)]
    kept = [at for at, fault in enumerate(faults) if not fault]
    if not kept:
        raise ValueError(
            f"{source}: none of {counted(len(faults), 'image')} can be read; the first: "
            f"{raw.images[0]}: {faults[0]}"
        )
    gone = {name: fault for name, fault in zip(raw.names, faults, strict=True) if fault}
    return replace(raw.subset(kept), dropped=raw.dropped | gone)


def _faults(files: Sequence[image_files.Image]) -> list[str]:
    return in_turn(lambda at: image_files.fault(files[at]), files)


def check_images(raw: RawCapture, long_side: int) -> None:
    """Refuse images and masks by their headers; those of a video are left to its decoder.

    Raises:
        ValueError: naming the file.
    """
    files = [
        (file, camera)
        for group in (raw.images, raw.masks or ())
        for file, camera in zip(group, raw.cameras, strict=False)
        if isinstance(file, Path)
    ]
    missing = next((file for file, _ in files if not file.is_file()), None)
    if missing is not None:  # before any is opened: a capture may have a million
        count = sum(not file.is_file() for file, _ in files)
        raise ValueError(
            f"{missing}: image file is missing ({count} in all). Hint: "
            "`skip_unreadable` (--skip-unreadable) leaves such frames out"
        )
    sizes = in_turn(lambda at: image_files.size_of(files[at][0]), [file for file, _ in files])
    first = frame = common_frame(raw.cameras, long_side)
    for (file, camera), size in zip(files, sizes, strict=True):
        try:
            brought = working_size(camera, size, long_side)
        except ValueError as error:
            raise ValueError(f"{file}: {error}") from error
        first = first or brought
        check_same_size(file, frame or brought, first)


def _agreeing(raw: RawCapture, source: str, bound: float) -> Agreement:
    """Agreement of the parts, refused where it is too poor."""
    agreement = measure(sample(raw)[1], bound)
    if agreement.share > bound:
        raise ValueError(
            f"{source}: {agreement}; allowed is a median of {bound * agreement.long_side:.1f}. "
            f"Likely cause: {agreement.cause}. Hint: `max_error` (--max-error) is the bound"
        )
    return agreement
