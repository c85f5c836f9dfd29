"""Dataset layouts: how captures lie on disk, and how they become canonical."""

from __future__ import annotations

import logging
from pathlib import Path

from fsel.capture import Capture
from fsel.layouts import (
    colmap,
    dl3dv,
    mipnerf360,
    nerfstudio,
    scannetpp,
    seven_scenes,
    tanks_and_temples,
)
from fsel.layouts.base import Layout, RawCapture
from fsel.layouts.ingest import ingest

log = logging.getLogger(__name__)

LAYOUTS: dict[str, Layout] = {
    layout.name: layout
    for layout in (
        scannetpp.DSLR,
        scannetpp.IPHONE,
        seven_scenes.LAYOUT,
        dl3dv.LAYOUT,
        mipnerf360.LAYOUT,
        nerfstudio.LAYOUT,
        colmap.LAYOUT,
        tanks_and_temples.LAYOUT,
    )
}
"""By name, the most particular first: the order in which `auto` asks."""


def read_raw(path: str | Path, layout: str = "auto") -> tuple[Layout, RawCapture]:
    """What a capture's files say, before images are opened; see `read_capture`."""
    folder = Path(path)
    if not folder.is_dir():
        raise FileNotFoundError(f"{folder}: no such folder")
    if layout == "auto":
        found = [known for known in LAYOUTS.values() if known.recognises(folder)]
        if not found:
            raise ValueError(f"{folder}: no known layout; known: {', '.join(LAYOUTS)}")
        log.info("%s: recognised as %s", folder, found[0].name)
        return found[0], found[0].read(folder)
    if layout not in LAYOUTS:
        raise ValueError(f"layout is {layout!r}; allowed: auto, {', '.join(LAYOUTS)}")
    return LAYOUTS[layout], LAYOUTS[layout].read(folder)


def read_capture(path: str | Path, layout: str = "auto", long_side: int = 128) -> Capture:
    """Read a capture from disk.

    Args:
        path: its folder.
        layout: a key of `LAYOUTS`, or `auto` to recognise it.
        long_side: pixels of the images' longer side.

    Raises:
        FileNotFoundError: when the folder, its model or its images are not there.
        ValueError: for an unknown layout, or files that contradict themselves.
    """
    known, raw = read_raw(path, layout)
    return ingest(raw, known, Path(path), long_side)
