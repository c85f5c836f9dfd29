"""A folder that `fsel select` wrote: its record, and its capture as the selection opened it."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from fsel.cli.options import OPENING
from fsel.core.capture import Capture
from fsel.core.geometry import turned
from fsel.selection.export.record import RECORD


def record_of(folder: Path) -> dict:
    """Content of the record in a folder; empty where there is none.

    Raises:
        ValueError: for a file that is no record.
    """
    file = folder / RECORD
    if not file.is_file():
        return {}
    try:
        record = json.loads(file.read_text(encoding="utf-8"))
        record["capture"]["opened"], record["capture"]["beside"], record["settings"]["k"]
        record["capture"]["folder"], record["frames"], record["left"], record["targets"]["held_out"]
    except (ValueError, TypeError, KeyError) as error:
        raise ValueError(f"{file}: is no record of fsel select ({error})") from error
    return record


def open_as(args: argparse.Namespace, record: dict) -> None:
    """Have a capture opened as the selection of a record opened it, which placed its video.

    Options of opening that the command line states stand; so does another capture.

    Args:
        args: the command line, which is changed.
        record: see `record_of`.
    """
    told = record.get("capture", {"folder": ""})
    stated = any(getattr(args, name) != default for name, default in OPENING.items())
    if stated or str(args.capture.resolve()) != told["folder"]:
        return
    beside = [Path(path) for path in told["beside"]]
    vars(args).update(told["opened"], beside=beside, k=record["settings"]["k"])


def of_selection(args: argparse.Namespace) -> dict:
    """The record where the capture of a command line is a folder that `fsel select` wrote.

    The capture that was chosen from takes its place, opened as there: a video would be placed with
    other frames, and in another world.
    """
    record = record_of(args.capture)
    if not record or not Path(record["capture"]["folder"]).exists():
        return {}  # the folder is a capture of the picks itself
    args.capture = Path(record["capture"]["folder"])
    open_as(args, record)
    return record


def as_written(capture: Capture, record: dict) -> Capture:
    """The capture of a record in the world that was written, which `--up` may have turned."""
    if record.get("turn") is None:
        return capture
    turn, points = np.array(record["turn"]), capture.points
    if points is not None:
        points = replace(points, xyz=points.xyz @ turn.T)
    poses = turned(capture.world_to_camera, turn)
    return replace(capture, world_to_camera=poses, points=points)
