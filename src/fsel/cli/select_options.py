"""The grammar of `fsel select`."""

from __future__ import annotations

import argparse
from pathlib import Path

from fsel.cli.options import (
    LARGEST,
    add_captures,
    add_keeping,
    add_object,
    add_opening,
    add_output,
    add_threads,
    bare_command,
    duration,
    number_or_auto,
    positive,
    size_in_bytes,
    whole,
    words,
)

TRAINERS = ("gsplat", "splatfacto", "nerfacto", "long-lrm")  # of `budget.TRAINERS`
RECORDED = (
    *("k", "targets", "weights", "patience", "masks", "box"),
    *("geometry_only", "keep_bad", "loss", "vram", "trainer", "always", "never", "long_side"),
    *("undistort", "views"),
)
"""Options that selection.json repeats, in its order."""


def add_select(commands) -> None:
    text = "Pick the frames that best serve the views to be rendered."
    command = bare_command(commands, "select", text)
    add_captures(command)
    add_threads(command)
    add_output(command, "folder to write")
    _add_number(command.add_argument_group("number of frames"))
    views = command.add_argument_group("views")
    text = (
        "views to render: path.json (a camera path), names.txt (frames to hold out, one per "
        "line), every:N (hold out every N-th frame), orbit, or trajectory (default: anything "
        "that the capture shows)"
    )
    views.add_argument("--targets", metavar="WHAT", help=text)
    add_object(views, "use targets that show the object, and measure features around it")
    _add_method(command.add_argument_group("selection method"))
    add_opening(command.add_argument_group("input"), unposed=True)
    _add_form(command.add_argument_group("output"))
    command.set_defaults(video_frames=None)


def _add_number(group: argparse._ArgumentGroup) -> None:
    text = (
        "number of frames, or auto to choose it automatically; of 360-degree panoramas, each with "
        "all its views, unless --views picks these one by one"
    )
    group.add_argument("-k", type=number_or_auto, required=True, help=text)
    group.add_argument("--views", action="store_true", help=argparse.SUPPRESS)
    text = (
        "with -k auto: dB of PSNR to lose against all frames at most, 9 times in 10 (default: 0.5)"
    )
    group.add_argument("--loss", type=positive, metavar="DB", help=text)
    text = "with -k auto: memory of the GPU, such as 8GB; --trainer NAME says what trains on it: "
    text += ", ".join(TRAINERS)
    group.add_argument("--vram", type=size_in_bytes, metavar="SIZE", help=text)
    group.add_argument("--trainer", choices=TRAINERS, help=argparse.SUPPRESS)


def _add_method(group: argparse._ArgumentGroup) -> None:
    text = "fsel (default), less_is_more, uniform, fvs, nearest, ..."
    group.add_argument("--method", help=text)
    text = "scorer trained by the workflow, .safetensors or .json; it implies the method"
    group.add_argument("--weights", type=Path, metavar="FILE", help=text)
    text = (
        "time to validate candidate selections on the capture's own frames, or on the images of "
        "--targets that are frames (default: 10s, or 1m with at least K such targets); 0 uses the "
        "rule alone"
    )
    group.add_argument("--patience", type=duration, metavar="TIME", help=text)
    for name, text in (("always", "to pick first"), ("never", "never to pick, despite --always")):
        text = f"frames {text}: names, or files of names such as frames.txt, between commas"
        group.add_argument(f"--{name}", type=words, metavar="NAMES", help=text)
    add_keeping(group)
    text = (
        "do not read images: no validation, no pictures in the report, no points if the capture "
        "has none, and of bad frames only misplaced ones are excluded"
    )
    group.add_argument("--geometry-only", action="store_true", help=text)


def _add_form(group: argparse._ArgumentGroup) -> None:
    text = "undistort images and cameras, for trainers without distortion models"
    group.add_argument("--undistort", action="store_true", help=text)
    size = group.add_mutually_exclusive_group()
    text = "downscale the images to this longer side"
    size.add_argument("--long-side", type=whole(1, LARGEST), metavar="PIXELS", help=text)
    text = (
        "hard-link the images at full size instead of copying them; images with an EXIF "
        "rotation are copied"
    )
    size.add_argument("--link", action="store_true", help=text)
