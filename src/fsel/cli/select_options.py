"""The grammar of `fsel select`."""

from __future__ import annotations

import argparse
from pathlib import Path

from fsel.cli.options import (
    LARGEST,
    add_output,
    add_request,
    capture_command,
    duration,
    number_or_auto,
    positive,
    size_in_bytes,
    whole,
)

TURNED, UNTURNED = "auto", "none"
MOST_TIMES = 20  # that a point is to be seen


def add_select(commands) -> None:
    command = capture_command(
        commands, "select", "Pick the frames that best serve the views to be rendered."
    )
    command.add_argument(
        "-k",
        type=number_or_auto,
        help="how many frames, or auto: until more are predicted to gain too little",
    )
    command.add_argument(
        "--cover",
        type=whole(1, MOST_TIMES),
        default=0,
        metavar="TIMES",
        help="as few frames as needed so that every sparse point that so many frames see is seen "
        "so often, from different directions; with -k, the rest of it is picked as usual",
    )
    command.add_argument(
        "--cover-share",
        type=positive,
        default=1.0,
        metavar="SHARE",
        help="of these points, as 0.9; all by default, which often take nearly all frames",
    )
    command.add_argument(
        "--patience",
        type=duration,
        metavar="TIME",
        help="for how long selections are tried on this capture's own frames, as 10s (by default, "
        "where nothing but -k is stated), or on the images of --targets that are frames, if it is "
        "stated; 0 for the rule alone",
    )
    _add_budget(command)
    add_request(command)
    _add_method(command)
    _add_looking(command)
    _add_wishes(command)
    _add_form(command)
    add_output(command, "folder to write")


def _add_budget(command: argparse.ArgumentParser) -> None:
    """Add options of how -k auto chooses a number of frames."""
    command.add_argument(
        "--threshold",
        type=positive,
        metavar="DB",
        help="of -k auto: least PSNR that further frames must gain each, 0.02 by default",
    )
    memory = command.add_mutually_exclusive_group()
    memory.add_argument(
        "--memory",
        type=size_in_bytes,
        metavar="SIZE",
        help="of -k auto: bytes that the splats of a reconstruction may take, as 500MB or 2GiB",
    )
    memory.add_argument(
        "--vram",
        type=size_in_bytes,
        metavar="SIZE",
        help="of -k auto: memory of the GPU that --trainer runs on, as 8GB",
    )
    command.add_argument(
        "--trainer",
        choices=("gsplat", "splatfacto", "nerfacto", "long-lrm"),  # of `budget.TRAINERS`
        help="what takes --vram; see docs/reconstructors.md",
    )


def _add_method(command: argparse.ArgumentParser) -> None:
    """Add options of what selects, and the appearance that it compares frames by."""
    command.add_argument(
        "--method", help="fsel (by default), less_is_more, uniform, fvs, nearest, ..."
    )
    command.add_argument(
        "--weights",
        type=Path,
        metavar="FILE",
        help="a scorer that the workflow made, .safetensors or .json; it says the method",
    )
    command.add_argument(
        "--appearance",
        default="lab_hog",
        metavar="KIND",
        help="descriptor of methods that compare frames by appearance: lab_hog (the default), or "
        "dinov2",
    )
    command.add_argument(
        "--appearance-weights", metavar="FILE", help="checkpoint of --appearance dinov2"
    )


def _add_looking(command: argparse.ArgumentParser) -> None:
    """Add options of which images are opened."""
    command.add_argument(
        "--geometry-only",
        action="store_true",
        help="do not look at images: nothing is tried on them, of bad frames only the misplaced "
        "are left out, no pictures in the report, no points where the capture has none",
    )


def _add_wishes(command: argparse.ArgumentParser) -> None:
    """Frames that are picked, or not, whatever the method says."""
    command.add_argument(
        "--always", type=Path, metavar="NAMES", help="file of frames that are picked first"
    )
    command.add_argument(
        "--never", type=Path, metavar="NAMES", help="file of frames that are not picked"
    )


def _add_form(command: argparse.ArgumentParser) -> None:
    """Add options of how the subset is written."""
    command.add_argument(
        "--points",
        choices=("seen", "all", "none"),
        default="seen",
        help="those that two picks see (by default; triangulated where the capture has none), all "
        "of the capture's, or none",
    )
    command.add_argument(
        "--undistort",
        action="store_true",
        help="write images and cameras without distortion, as trainers without it need",
    )
    command.add_argument(
        "--up",
        choices=(TURNED, UNTURNED),
        default=UNTURNED,
        help="auto: turn the world that is written until z points upwards, by the cameras' "
        "horizontal axes; none (by default): the capture's own world",
    )
    command.add_argument(
        "--sheet",
        action="store_true",
        help="write sheet.png too: every frame in one picture, picks, held-out and bad ones marked",
    )
    size = command.add_mutually_exclusive_group()
    size.add_argument(
        "--long-side",
        type=whole(1, LARGEST),
        metavar="PIXELS",
        help="reduce the images to this longer side; --memory is counted by it",
    )
    size.add_argument(
        "--downscale", type=whole(1, 64), metavar="N", help="reduce the images to one N-th"
    )
    size.add_argument(
        "--link",
        action="store_true",
        help="hard-link the images, at the size they have, instead of copying them; those whose "
        "EXIF asks for a turn are copied",
    )
