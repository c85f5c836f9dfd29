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
    bare_command,
    duration,
    number_or_auto,
    positive,
    size_in_bytes,
    whole,
)

TURNED, UNTURNED = "auto", "none"
MOST_TIMES = 20  # that a point is to be seen
RECORDED = (
    *("k", "targets", "weights", "patience", "cover", "cover_share", "masks", "box"),
    *("geometry_only", "keep_bad", "vram", "trainer", "always", "never", "long_side"),
    *("undistort", "up"),
)
"""Options that selection.json repeats, in its order."""


def add_select(commands) -> None:
    text = "Pick the frames that best serve the views to be rendered."
    command = bare_command(commands, "select", text)
    add_captures(command)
    add_output(command, "folder to write")
    _add_number(command.add_argument_group("how many frames"))
    views = command.add_argument_group("for which views")
    text = (
        "the views to be rendered: path.json (a camera path), names.txt (frames, one a line, "
        "held out), every:N (every N-th frame, held out), orbit, or trajectory; without it, "
        "anything that the capture saw"
    )
    views.add_argument("--targets", metavar="WHAT", help=text)
    add_object(views, "targets that see the object, and features measured around it")
    _add_method(command.add_argument_group("what picks"))
    add_opening(command.add_argument_group("how the capture is opened"), unposed=True)
    _add_form(command.add_argument_group("how the frames are written"))
    command.set_defaults(video_frames=None)


def _add_number(group: argparse._ArgumentGroup) -> None:
    text = "how many frames, or auto: until more are predicted to gain too little"
    group.add_argument("-k", type=number_or_auto, help=text)
    text = "of -k auto: memory of the GPU that --trainer runs on, as 8GB"
    group.add_argument("--vram", type=size_in_bytes, metavar="SIZE", help=text)
    group.add_argument(
        "--trainer",
        choices=("gsplat", "splatfacto", "nerfacto", "long-lrm"),  # of `budget.TRAINERS`
        help="what takes --vram; see docs/reconstructors.md",
    )
    text = (
        "as few frames as needed so that every sparse point that so many frames see is seen "
        "so often, from different directions; with -k, the rest of it is picked as usual"
    )
    group.add_argument("--cover", type=whole(1, MOST_TIMES), default=0, metavar="TIMES", help=text)
    text = "of these points, as 0.9; all by default, which often take nearly all frames"
    group.add_argument("--cover-share", type=positive, default=1.0, metavar="SHARE", help=text)


def _add_method(group: argparse._ArgumentGroup) -> None:
    text = "fsel (by default), less_is_more, uniform, fvs, nearest, ..."
    group.add_argument("--method", help=text)
    text = "a scorer that the workflow made, .safetensors or .json; it says the method"
    group.add_argument("--weights", type=Path, metavar="FILE", help=text)
    text = (
        "for how long selections are tried on this capture's own frames, as 10s (by default, "
        "where nothing but -k is stated), or on the images of --targets that are frames, if it is "
        "stated; 0 for the rule alone"
    )
    group.add_argument("--patience", type=duration, metavar="TIME", help=text)
    for name, text in (("always", "that are picked first"), ("never", "that are not picked")):
        group.add_argument(f"--{name}", type=Path, metavar="NAMES", help=f"file of frames {text}")
    add_keeping(group)
    text = (
        "do not look at images: nothing is tried on them, of bad frames only the misplaced "
        "are left out, no pictures in the report, no points where the capture has none"
    )
    group.add_argument("--geometry-only", action="store_true", help=text)


def _add_form(group: argparse._ArgumentGroup) -> None:
    text = "write images and cameras without distortion, as trainers without it need"
    group.add_argument("--undistort", action="store_true", help=text)
    text = (
        "auto: turn the world that is written until z points upwards, by the cameras' "
        "horizontal axes; none (by default): the capture's own world"
    )
    group.add_argument("--up", choices=(TURNED, UNTURNED), default=UNTURNED, help=text)
    size = group.add_mutually_exclusive_group()
    text = "reduce the images to this longer side"
    size.add_argument("--long-side", type=whole(1, LARGEST), metavar="PIXELS", help=text)
    text = (
        "hard-link the images, at the size they have, instead of copying them; those whose "
        "EXIF asks for a turn are copied"
    )
    size.add_argument("--link", action="store_true", help=text)
