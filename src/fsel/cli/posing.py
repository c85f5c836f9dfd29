"""Captures whose poses must be found first: a video, or photos, through COLMAP; kept for later."""

from __future__ import annotations

import argparse
import hashlib
import json
import shutil
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict, replace
from pathlib import Path

from fsel.cli.console import Console
from fsel.colmap.bindings import pycolmap
from fsel.colmap.runs import MIN_PLACED, Work
from fsel.images import files as image_files
from fsel.images import orientation, video
from fsel.images.previews import check_pixels
from fsel.ingest import sfm
from fsel.ingest.lazy import LONG_SIDE, LazyCapture, open_capture
from fsel.layouts import bare
from fsel.utils.cache import cache
from fsel.utils.limits import cores
from fsel.utils.wording import counted

CAPTURE, FOUND = "capture", "poses.json"
SHOWN = 8  # names of frames that were not placed
UNREAD = (".heic", ".heif", ".avif", ".webp", ".tif", ".tiff", ".bmp", ".dng")  # not for COLMAP
MADE = 3  # of what is kept: counted up where the same files are placed otherwise than before


def opened(args: argparse.Namespace, console: Console, long_side: int = LONG_SIDE) -> LazyCapture:
    """The capture of a command line, or the one that COLMAP makes of its video or photos.

    Args:
        args: the parsed command line.
        console: prints what is done.
        long_side: pixels of the longer side of images that are opened later.

    Raises:
        ValueError: for a video or photos that cannot be placed, options that do not fit, and all
            that `open_capture` refuses.
    """
    if not needed(args):
        with console.clock("reading"):
            capture = open_capture(
                args.capture,
                args.layout,
                long_side,
                args.max_error,
                skip_unreadable=args.skip_unreadable,
            )
        warn_of(capture.skipped, console)
        return capture
    place = found_poses(args, console)
    capture = open_capture(place / CAPTURE, "colmap", long_side, args.max_error)
    known = f"colmap at {args.capture}"  # as a person knows it, not as the cache does
    return replace(capture, capture=replace(capture.capture, source=known))


def warn_of(skipped: dict[str, str], console: Console) -> None:
    """Name the frames whose images cannot be read."""
    if skipped:
        named = [f"{name} ({why})" for name, why in skipped.items()]
        more = f", and {len(named) - SHOWN} more" if len(named) > SHOWN else ""
        console.warn(f"{counted(len(named), 'image')} skipped: {', '.join(named[:SHOWN])}{more}")


def needed(args: argparse.Namespace) -> bool:
    """Check whether poses are to be found; refuse options that would have no effect."""
    filmed = video.is_video(args.capture)
    if not filmed and (args.video_frames is not None or args.rate is not None):
        raise ValueError(f"{args.capture}: is no video, which --video-frames and --rate are for")
    return filmed or args.poses == "colmap"


def found_poses(args: argparse.Namespace, console: Console) -> Path:
    """A folder with `capture`, a COLMAP capture, and `poses.json`, the report.

    It lies in the user's cache, under a digest of the files and settings: the second time nothing
    is matched, and a run that was cut off goes on where it was.

    Raises:
        ValueError: when the source holds too few images, or one that cannot be read, or fewer than
            three can be placed.
    """
    source = args.capture
    settings = {"frames": args.video_frames, "rate": args.rate}
    files = [source] if video.is_video(source) else _photos(args, console)
    place = cache() / _digest(files, settings)
    place.mkdir(parents=True, exist_ok=True)
    with locked(place / "lock"):
        if not (place / FOUND).is_file():
            _find(source, files, settings, place, console)
    report = json.loads((place / FOUND).read_text(encoding="utf-8"))
    missing = report["not_placed"]
    console.say("poses", f"COLMAP placed {len(report['placed'])} of {report['frames']} frames")
    if missing:
        more = f", and {len(missing) - SHOWN} more" if len(missing) > SHOWN else ""
        console.warn(
            f"{counted(len(missing), 'frame')} not placed: {', '.join(missing[:SHOWN])}{more}"
        )
    return place


def _photos(args: argparse.Namespace, console: Console) -> list[Path]:
    """The photos of a folder; without `--skip-unreadable` all must be sound."""
    source = args.capture
    if not source.is_dir():
        why = "is neither a video nor a folder of photos" if source.exists() else "no such folder"
        raise ValueError(f"{source}: {why}")
    files = bare.find(source)
    if args.skip_unreadable:
        faults = {file.name: image_files.fault(file) for file in files}
        warn_of({name: why for name, why in faults.items() if why}, console)
        files = [file for file in files if not faults[file.name]]
    if other := sorted(file.name for file in source.iterdir() if file.suffix.lower() in UNREAD):
        few = ", ".join(other[:SHOWN])
        console.warn(
            f"{counted(len(other), 'photo')} not read until converted to JPEG or PNG: {few}"
        )
    if len(files) < MIN_PLACED:
        raise ValueError(
            f"{source}: {counted(len(files), 'photo')} ({', '.join(bare.ENDINGS)}) in it, in "
            f"images or in input; at least {MIN_PLACED} are needed"
        )
    if not args.skip_unreadable:
        check_pixels(files)
    return files


def _digest(files: Sequence[Path], settings: dict) -> str:
    stamps = [(str(file.resolve()), file.stat().st_size, file.stat().st_mtime_ns) for file in files]
    known = json.dumps([stamps, settings, pycolmap.__version__, MADE])
    return hashlib.sha256(known.encode()).hexdigest()[:16]


def _find(
    source: Path, files: Sequence[Path], settings: dict, place: Path, console: Console
) -> None:
    """Fill a folder of the cache; `poses.json` comes last."""
    folder = place / CAPTURE / "images"
    report: dict[str, object] = {"source": str(source), "settings": settings}
    filmed = video.is_video(source)
    if filmed:
        shutil.rmtree(folder, ignore_errors=True)
        kept = video.thin(source, folder, **settings, progress=console.bar("video"))
        console.say("video", f"the sharpest of each of {len(kept)} stretches of {source.name}")
        report["video"] = [asdict(shot) for shot in kept]
    else:
        report["turned"] = _put(files, folder, console)
    raw = bare.read(place / CAPTURE)
    work = Work(place / "matching", cores(), ordered=filmed, watch=console.bar)
    try:
        model = sfm.place(raw, work=work)
    except sfm.NotPlaced as error:
        raise ValueError(
            f"{source}: {error.said}; at least {MIN_PLACED} are needed. Hint: more images that "
            "overlap each other"
        ) from error
    sparse = place / CAPTURE / "sparse" / "0"
    sparse.mkdir(parents=True, exist_ok=True)
    model.write_binary(str(sparse))
    placed = {image.name for image in model.images.values()}
    report |= {
        "frames": len(raw.names),
        "placed": [name for name in raw.names if name in placed],
        "not_placed": [name for name in raw.names if name not in placed],
    }
    shutil.rmtree(place / "matching")
    partial = place / f".{FOUND}"
    partial.write_text(json.dumps(report, indent=1), encoding="utf-8")
    partial.replace(place / FOUND)


def _put(files: Sequence[Path], folder: Path, console: Console) -> list[str]:
    """Links to photos, and upright copies of those whose EXIF asks for a turn, which are named."""
    folder.mkdir(parents=True, exist_ok=True)
    turned = []
    for file in console.bar("photos")(files, len(files)):
        place = folder / file.name
        place.unlink(missing_ok=True)
        if orientation.of_file(file) == orientation.UPRIGHT:
            place.symlink_to(file.resolve())
        else:
            image_files.write_upright(file, place)
            turned.append(file.name)
    if turned:
        how = f"as their EXIF says; JPEGs encoded again at quality {image_files.QUALITY}"
        console.say("turned", f"{len(turned)} of {len(files)} photos upright, {how}")
    return turned


def locked(path: Path) -> AbstractContextManager:
    """A block that begins when no other process is within one of the same file."""
    from filelock import FileLock  # here: most captures have their poses

    return FileLock(path)
