"""Captures read from disk in any layout, checked, and made canonical."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from numbers import Integral
from pathlib import Path
from typing import Any

import numpy as np

from fsel.captures.canonical import check_same_size, in_order, ingest
from fsel.captures.colmap.runs import Work, work_of
from fsel.captures.colmap.undistortion import common_frame, working_size
from fsel.captures.images import files as image_files
from fsel.captures.images.previews import in_turn
from fsel.captures.layouts import LAYOUTS, bare, colmap
from fsel.captures.layouts.contract import Layout, RawCapture
from fsel.captures.poses import sfm
from fsel.captures.poses.agreement import Agreement, measure
from fsel.core.capture import Capture
from fsel.core.limits import MAX_ERROR
from fsel.core.names import natural
from fsel.core.subsets import evenly
from fsel.core.wording import check_type, counted

log = logging.getLogger(__name__)

POSES = ("layout", "colmap", "file")
POINTS = ("layout", "triangulate")
TRIANGULATION_LONG_SIDE = 800


@dataclass(frozen=True)
class Ingestion:
    """A canonical capture, how well its parts agree, and why frames were left out."""

    capture: Capture
    agreement: Agreement
    dropped: dict[str, str]


def recognise(folder: str | Path) -> list[str]:
    """Return the names of the layouts that a folder looks like, the most particular first."""
    return [layout.name for layout in LAYOUTS.values() if layout.recognises(Path(folder))]


def read_raw(
    path: str | Path, layout: str = "auto", reading: dict | None = None
) -> tuple[Layout, RawCapture]:
    """Return layout and raw capture of a folder, before images are opened; see `read_folder`."""
    known = _layout_of(Path(path), layout)
    for key in reading or {}:
        if key not in known.options:
            allowed = ", ".join(known.options) or "nothing"
            raise ValueError(f"reading.{key}: layout {known.name} takes {allowed}")
    with np.errstate(over="ignore", invalid="ignore"):  # what becomes of it is refused by name
        return known, known.read(Path(path), **reading or {})


def read_capture(
    path: str | Path, layout: str = "auto", long_side: int = 128, **options
) -> Capture:
    """Read a capture from disk, its images of `long_side` pixels; `options` are of `read_folder`.

    Example:
        >>> capture = fsel.read_capture("captures/garden", long_side=48)
        >>> len(capture), capture.size
        (80, (48, 36))
    """
    return read_folder(path, layout, long_side, **options).capture


def read_folder(
    path: str | Path,
    layout: str = "auto",
    long_side: int = 128,
    *,
    poses: str | Mapping[str, Any] = "layout",
    model: str = "",
    points: str = "layout",
    every: int = 1,
    max_error: float = MAX_ERROR,
    skip_unreadable: bool = False,
    reading: dict | None = None,
    store: Path | None = None,
) -> Ingestion:
    """Read a capture from disk, with the agreement of its parts and the frames left out.

    Args:
        path: its folder.
        layout: a key of `LAYOUTS`, or `auto` to recognise it.
        long_side: pixels of the images' longer side.
        poses: `layout` for the dataset's own; `colmap` for COLMAP's from the images alone; `file`
            for those of the COLMAP model in the folder `model`; or a mapping, see
            `fsel.captures.colmap.runs.work_of`: other features, or a program that finds them.
        model: folder inside the capture, for `poses="file"`.
        points: `layout` for the dataset's own, if any; `triangulate` to make them otherwise.
        every: keep every n-th frame of each sequence.
        max_error: greatest median disagreement of poses and images, as a share of the images'
            longer side (see `Agreement`).
        skip_unreadable: leave out frames whose image is missing or cannot be decoded, and log them.
        reading: keywords of the layout's own reader.
        store: folder for the image arrays, so that memory stays small; None for memory.

    Raises:
        FileNotFoundError: when the folder, its model or its images are not there.
        ValueError: for an unknown choice, or files that contradict themselves.
    """
    check_type("path", path, (str, Path), "a folder")
    check_type("long_side", long_side, Integral, "a whole number of pixels")
    folder = Path(path)
    _allowed("points", points, POINTS)
    known, raw = read_posed(folder, layout, poses, model, every, reading)
    source = f"{known.name} at {folder}"
    raw, agreement = validated(raw, source, long_side, max_error, skip_unreadable=skip_unreadable)
    for reason, count in sorted(Counter(raw.dropped.values()).items()):
        log.info("%s: left out %d frames: %s", source, count, reason)
    log.info("%s: %s", source, agreement)
    capture = ingest(raw, source, long_side, store=store)
    if capture.points is None and points == "triangulate":
        large = ingest(raw, source, TRIANGULATION_LONG_SIDE, lazy=True)
        capture = replace(capture, points=sfm.triangulate(large))
    if capture.points is None:
        log.info("%s: no sparse points; co-visibility is predicted from the poses", source)
    return Ingestion(capture, agreement, raw.dropped)


def read_posed(
    folder: Path,
    layout: str = "auto",
    poses: str | Mapping[str, Any] = "layout",
    model: str = "",
    every: int = 1,
    reading: dict | None = None,
) -> tuple[Layout, RawCapture]:
    """Return layout and raw capture of a folder with its poses found; see `read_folder`."""
    work = Work() if isinstance(poses, str) else work_of(poses)
    if isinstance(poses, str):
        _allowed("poses", poses, POSES)
    if layout == "auto" and poses != "layout" and not recognise(folder):
        layout = bare.LAYOUT.name
    known, raw = read_raw(folder, layout, reading)
    raw = _thinned(raw, every)
    if poses == "colmap" or not isinstance(poses, str):
        raw = sfm.reconstruct(raw, work)
    elif poses == "file":
        if not model:
            raise ValueError(f"{folder}: poses come from a file, but `model` names no folder")
        raw = sfm.with_model(raw, colmap.load_model(folder / model), f"not in {model}")
    return known, raw


def _layout_of(folder: Path, layout: str) -> Layout:
    if folder.is_file():
        what = f"is a file, not a folder with images and poses{bare.explained(folder)}"
        raise ValueError(f"{folder}: {what}")
    if not folder.is_dir():
        none = "no such file" if folder.suffix else "no such folder"
        raise FileNotFoundError(f"{folder}: {'is a device or pipe' if folder.exists() else none}")
    if layout != "auto":
        _allowed("layout", layout, ("auto", *LAYOUTS))
        return LAYOUTS[layout]
    names = recognise(folder)
    pictured = any((folder / name).is_dir() for name in colmap.IMAGE_FOLDERS)
    if not names or (names[0] == colmap.LAYOUT.name and not pictured):
        scenes = _captures_in(folder)
        outer = folder.resolve().parents[:2]
        # a layout may look one folder down: a folder beside a capture is not part of it
        around = next((one for one in outer if recognise(one) and not _captures_in(one)), None)
        hint = ""
        if around is not None:
            hint = f"; it is part of the capture {around}, give that folder"
        elif scenes:
            hint = f"; its folders {scenes[:3]} are captures, give one of them"
        elif names:
            return LAYOUTS[names[0]]  # its reader says that the images are missing
        else:
            hint = bare.explained(folder)
        raise ValueError(f"{folder}: no known layout ({', '.join(LAYOUTS)}){hint}")
    also = f" (it also looks like {', '.join(names[1:])})" if names[1:] else ""
    log.info("%s: recognised as %s%s", folder, names[0], also)
    return LAYOUTS[names[0]]


def _captures_in(folder: Path) -> list[str]:
    """Return the names of the folders in a folder that are captures."""
    inner = [child for child in sorted(folder.iterdir()) if child.is_dir()]
    return [child.name for child in inner if recognise(child)]


def _thinned(raw: RawCapture, every: int) -> RawCapture:
    """Every n-th frame of each sequence, in natural order."""
    if every == 1:
        return raw
    rows: dict[str, list[int]] = {}
    for i in sorted(range(len(raw.names)), key=lambda i: natural(raw.names[i])):
        rows.setdefault(raw.sequences[i], []).append(i)
    kept = sorted(i for row in rows.values() for i in row[::every])
    return raw.subset(kept, f"skipped by every: {every}")


def _allowed(key: str, value: str, allowed: tuple[str, ...]) -> None:
    if value not in allowed:
        raise ValueError(f"{key} is {value!r}; allowed: {', '.join(allowed)}")


LEAST_SIDE = 11  # pixels: the window in which SSIM compares images
SAMPLE = 300  # frames whose points are read: a long capture has millions


def validated(
    raw: RawCapture,
    source: str,
    long_side: int,
    max_error: float = MAX_ERROR,
    *,
    skip_unreadable: bool = False,
) -> tuple[RawCapture, Agreement]:
    """Return a capture's frames in natural order, and how well their parts agree.

    Every image's header is read. Pixels are decoded only where poses have no points to agree with,
    or where `skip_unreadable` asks which can be. Other arguments are `read_folder`'s.
    """
    raw = in_order(raw, source)
    if skip_unreadable:
        raw = _readable(raw, source)
    check_images(raw, long_side)
    agreement = measure(sample(raw)[1], max_error)
    if agreement.share > max_error:
        raise ValueError(
            f"{source}: {agreement}; allowed is a median of "
            f"{max_error * agreement.long_side:.1f}. Likely cause: {agreement.cause}. Hint: "
            "`max_error=SHARE` sets the limit"
        )
    return raw, agreement


def sample(raw: RawCapture) -> tuple[np.ndarray, RawCapture]:
    """Return (m,) int64 frames, evenly drawn if many, and what the files say of them."""
    drawn = evenly(len(raw.names), SAMPLE)
    return drawn, raw.subset(drawn.tolist())


def _readable(raw: RawCapture, source: str) -> RawCapture:
    """The frames whose image and mask can be opened; others are dropped, each with its fault."""
    files = [*raw.images, *(raw.masks or ())]
    faults = in_turn(lambda at: image_files.fault(files[at]), files)
    if raw.masks:  # an image's own fault before its mask's
        count = len(raw.names)
        faults = [one or other for one, other in zip(faults[:count], faults[count:], strict=True)]
    kept = [at for at, fault in enumerate(faults) if not fault]
    if not kept:
        raise ValueError(
            f"{source}: none of {counted(len(faults), 'image')} can be read; the first: "
            f"{raw.images[0]}: {faults[0]}"
        )
    gone = {name: fault for name, fault in zip(raw.names, faults, strict=True) if fault}
    return replace(raw.subset(kept), dropped=raw.dropped | gone)


def check_images(raw: RawCapture, long_side: int) -> None:
    """Refuse images and masks by their headers; those of a video are left to its decoder."""
    files = [
        (file, camera)
        for group in (raw.images, raw.masks or ())
        for file, camera in zip(group, raw.cameras, strict=False)
        if isinstance(file, Path)
    ]
    missing = [file for file, _ in files if not file.is_file()]
    if missing:  # before any is opened: a capture may have a million
        raise ValueError(
            f"{missing[0]}: image file is missing ({len(missing)} in all). Hint: "
            "`skip_unreadable=True` leaves such frames out"
        )
    sizes = in_turn(lambda at: image_files.size_of(files[at][0]), [file for file, _ in files])
    first = frame = common_frame(raw.cameras, long_side)
    for (file, camera), size in zip(files, sizes, strict=True):
        if min(size) < LEAST_SIDE:
            raise ValueError(
                f"{file}: an image of {size[0]}x{size[1]} pixels; both sides need {LEAST_SIDE} or "
                "more. Hint: leave it out of the capture"
            )
        try:
            brought = working_size(camera, size, long_side)
        except ValueError as error:
            raise ValueError(f"{file}: {error}") from error
        first = first or brought
        check_same_size(file, frame or brought, first)
