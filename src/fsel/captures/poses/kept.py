"""Poses that are kept in the user's cache, which a full disk or a power cut may damage."""

from __future__ import annotations

import shutil
from contextlib import AbstractContextManager
from pathlib import Path
from tempfile import TemporaryFile

from fsel.captures.images import files as image_files
from fsel.captures.layouts import colmap
from fsel.captures.parsing import read_json
from fsel.captures.poses.placement import MODEL
from fsel.captures.reporter import Reporter
from fsel.captures.sampling import IMAGES

CAPTURE, FOUND, LOCK, MATCHING = "capture", "poses.json", "lock", "matching"
WRITTEN = {"sources", "by", "video", "frames", "placed", "not_placed", "lost"}  # into poses.json
ROOM = 1 << 20  # bytes that a disk which is not full has


def locked(path: Path, seconds: float = -1) -> AbstractContextManager:
    """A block that begins when no other process is within one of the same file; `TimeoutError`
    after some seconds, unless below 0."""
    from filelock import FileLock  # here: most captures have their poses

    return FileLock(path, seconds)


def found_in(place: Path, reporter: Reporter) -> dict | None:
    """Return what an earlier run found; None where none did, or where it is damaged and cleared."""
    if not (place / FOUND).is_file():
        return None
    try:
        found = read_json(place / FOUND)
        if lacking := WRITTEN - set(found):
            raise ValueError(f"{place / FOUND}: lacks {', '.join(sorted(lacking))}")
        for image in colmap.load_model(place / CAPTURE / MODEL).images.values():
            image_files.size_of(place / CAPTURE / IMAGES / image.name)
    except ValueError as error:
        clear(place, error, reporter)
        return None
    return found


def clear(place: Path, error: Exception, reporter: Reporter) -> None:
    """Remove what an earlier run left, which an error says to be damaged."""
    reporter.warn(f"{error}; what is kept in {place} is damaged: finding the poses anew")
    (place / FOUND).unlink(missing_ok=True)
    for folder in (path for path in place.iterdir() if path.is_dir()):
        shutil.rmtree(folder)


def check_room(place: Path) -> None:
    """Raise the error of a full disk, whatever words a library finds for it."""
    try:
        with TemporaryFile(dir=place) as probe:
            probe.write(bytes(ROOM))
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(place)) from error
