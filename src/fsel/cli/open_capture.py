"""The capture that a command line names, and the files that it reads; also of a selection."""

from __future__ import annotations

import argparse
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from fsel.captures.lazy import LONG_SIDE, LazyCapture
from fsel.captures.opening import Opening
from fsel.captures.opening import opened as open_source
from fsel.captures.parsing import read_json
from fsel.cli.console import Console
from fsel.cli.options import OPENING
from fsel.core.wording import counted
from fsel.selection.export.record import RECORD

READ = ("capture", "masks", "pose_masks", "frames", "targets", "weights", "always", "never")


def opening_of(args: argparse.Namespace) -> Opening:
    """Return what a command line says of opening its capture."""
    k, views = getattr(args, "k", None), getattr(args, "views", False)
    numbers = [n for n in (k if isinstance(k, list) else [k]) if isinstance(n, int)]
    stated: dict[str, Any] = {n: getattr(args, n, usual) for n, usual in OPENING.items()}
    return Opening(
        paths=(args.capture, *args.beside),
        by=tuple(args.by or ()),
        mask_by=tuple(args.mask_by or ()),
        wanted=0 if views else max(numbers, default=0),
        views=views,
        **stated,
    )


def opened(args: argparse.Namespace, console: Console, long_side: int = LONG_SIDE) -> LazyCapture:
    """Open the capture of a command line; see `fsel.captures.opening.opened`."""
    source = open_source(opening_of(args), console, long_side)
    centers = source.capture.centers
    if not np.ptp(centers, axis=0).any():
        console.warn(
            f"{args.capture}: all {counted(len(centers), 'camera')} are at one place: nothing "
            "tells how far the scene is. Hint: walk around it"
        )
    return source


def inputs_of(args: argparse.Namespace) -> list[Path]:
    """Return the files and folders that a command line names to be read."""
    named = [getattr(args, name, None) for name in (*READ, "beside")]
    words = [word for name in named for word in (name if isinstance(name, list) else [name])]
    return [Path(word) for word in words if word is not None and Path(word).exists()]


def reasons(dropped: dict[str, str]) -> str:
    """Return the reasons why frames were left out, and how many for each."""
    return ", ".join(f"{reason} ({count})" for reason, count in Counter(dropped.values()).items())


def record_of(folder: Path) -> dict:
    """Read the record in a folder, empty where there is none; ValueError for another file."""
    file = folder / RECORD
    if not file.is_file():
        return {}
    record = read_json(file)
    try:
        record["capture"]["opened"], record["capture"]["beside"], record["settings"]["k"]
        record["capture"]["folder"], record["frames"], record["left"], record["targets"]["held_out"]
    except (TypeError, KeyError) as error:
        raise ValueError(f"{file}: is not a record of fsel select ({error})") from error
    return record


def open_as(args: argparse.Namespace, record: dict) -> None:
    """Change a command line so that its capture is opened as the selection of a record opened it.

    Options of opening that the command line states stand; so does another capture.
    """
    known = record.get("capture", {"folder": ""})
    stated = any(getattr(args, name) != default for name, default in OPENING.items())
    if stated or str(args.capture.resolve()) != known["folder"]:
        return
    beside = [Path(path) for path in known["beside"]]
    vars(args).update(known["opened"], beside=beside, k=record["settings"]["k"])


def open_of_selection(args: argparse.Namespace) -> None:
    """Replace a folder that `fsel select` wrote by the capture that was chosen from, opened as
    there: a video would be placed with other frames, and in another world."""
    record = record_of(args.capture)
    if record and Path(record["capture"]["folder"]).exists():
        args.capture = Path(record["capture"]["folder"])
        open_as(args, record)
