"""The command line's grammar; each command's module is imported when it runs."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from decimal import Decimal
from importlib.metadata import version
from pathlib import Path

from fsel.cli.options import (
    add_captures,
    add_checking,
    add_features,
    add_keeping,
    add_object,
    add_opening,
    add_output,
    add_size,
    add_skipping,
    add_video,
    bare_command,
    capture_command,
    numbers,
    positive,
    whole,
    words,
)
from fsel.cli.select_options import add_select
from fsel.cli.usage import Parser

EXPONENT = re.compile(r"-(\d+\.?\d*|\.\d+)[eE][-+]?\d{1,3}")


def parser() -> argparse.ArgumentParser:
    """Return the grammar of all commands."""
    root = Parser(
        prog="fsel",
        description="Choose the frames of a posed capture that a novel-view reconstructor "
        "should be fed.",
    )
    root.add_argument("--version", action="version", version=f"fsel {version('fsel')}")
    commands = root.add_subparsers(required=True, metavar="COMMAND")
    text = "Generate a small capture, and its video, to try fsel on."
    demo = bare_command(commands, "demo", text)
    demo.add_argument("scene", choices=("garden",), help="what it shows: garden")
    add_output(demo, "folder to write")
    _add_poses(commands)
    add_select(commands)
    text = "Say what a capture holds, and how many frames seem worth keeping."
    add_checking(capture_command(commands, "info", text))
    _add_compare(commands)
    _add_reconstruct(commands)
    _add_render(commands)
    _add_view(commands)
    return root


def parsed(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Parse a command line, by default the process' own.

    Negative numbers with exponents are written out: argparse takes them for options.
    """
    given = sys.argv[1:] if arguments is None else arguments
    words = [f"{Decimal(word):f}" if EXPONENT.fullmatch(word) else word for word in given]
    return parser().parse_args(words, argparse.Namespace(words=words))


def _add_poses(commands) -> None:
    text = "Find the poses of a video or of photos, and write them as a capture."
    command = bare_command(commands, "poses", text)
    add_captures(command)
    found = command.add_mutually_exclusive_group()
    add_features(found)
    text = (
        "program that finds the poses in the place of COLMAP's own mapper, in one argument, "
        "such as '{python} {recipes}/glomap.py {folder}'; several are run one after the other"
    )
    found.add_argument("--by", metavar="COMMAND", action="append", help=text)
    add_video(command)
    add_skipping(command)
    add_output(command, "folder to write")


def _add_compare(commands) -> None:
    text = "Reconstruct from what several methods pick, and compare with held-out frames."
    command = capture_command(commands, "compare", text)
    command.add_argument(
        "-k", type=numbers, default=[10, 20, 30], help="numbers of frames, 10,20,30 by default"
    )
    text = "names, fsel,uniform,fvs by default"
    command.add_argument("--methods", type=words, default=["fsel", "uniform", "fvs"], help=text)
    text = (
        "the frames that are held out and compared with: every:N (every N-th; every:8 by "
        "default), or names.txt (one a line)"
    )
    command.add_argument("--targets", metavar="WHAT", default="every:8", help=text)
    add_keeping(command)
    add_checking(command)
    add_object(command, "frames that see the object, compared inside of their masks")
    command.add_argument("--seed", type=whole(0), default=0, help="of methods that draw at random")
    _add_reconstructor(command)
    _add_metrics(command)
    add_size(command, default=192)
    add_output(command, "folder to write")


def _add_reconstruct(commands) -> None:
    text = "Write a model of some frames as a 3DGS .ply."
    command = capture_command(commands, "reconstruct", text)
    text = (
        "file with a frame name a line, as frames.txt; all by default: a folder that `fsel "
        "select` wrote holds its picks"
    )
    command.add_argument("--frames", type=Path, help=text)
    text = "by gaussians, of 384, 640 or 960 pixels; draft where no option below is stated"
    command.add_argument("--quality", choices=("draft", "good", "best"), help=text)
    _add_reconstructor(command, "splats or gaussians")
    add_size(command, None, "that of --quality")
    add_output(command, "file to write")
    command.set_defaults(reconstructor=None)


def _add_render(commands) -> None:
    text = "Render a 3DGS .ply: compared with the frames of a capture, or as a video."
    command = bare_command(commands, "render", text)
    command.add_argument("model", type=Path, help="3D Gaussian splatting .ply")
    text = "folder of the capture, in its world frame"
    command.add_argument("--capture", type=Path, required=True, help=text)
    add_opening(command)
    text = (
        "the views: every:N or names.txt (frames, which are compared), path.json, orbit or "
        "trajectory (which have no truth to compare with)"
    )
    command.add_argument("--targets", metavar="WHAT", required=True, help=text)
    _add_metrics(command)
    add_size(command, None, "384 (of a video 1280)")
    text = "a flight along the views instead, or between the frames: .mp4 to write"
    place = add_output(command, "folder to write")
    place.add_argument("--video", type=Path, metavar="FILE", help=text)
    text = "of the video, 5 by default; 30 frames each"
    command.add_argument("--seconds", type=positive, default=5.0, help=text)
    command.set_defaults(beside=[])


def _add_view(commands) -> None:
    text = "Write a page that shows a 3DGS .ply, or a capture's points, with cameras and photos."
    command = bare_command(commands, "view", text)
    text = "a 3DGS .ply, a folder that `fsel select` wrote, a capture: one or more of them"
    command.add_argument("source", type=Path, nargs="+", help=text)
    add_opening(command)
    add_size(command, default=480)
    place = add_output(command, "page to write, .html")
    place.add_argument(
        "--serve",
        type=whole(0, 65535),
        nargs="?",
        const=8000,
        metavar="PORT",
        help="show it from this machine instead, for models of 100 MB and more; 8000 by default",
    )
    command.set_defaults(capture=None, beside=[])


def _add_metrics(command: argparse.ArgumentParser) -> None:
    text = "psnr,ssim,gmsd by default; lpips fetches its weights, 64 MB, the first time"
    command.add_argument("--metrics", type=words, default=(), help=text)


def _add_reconstructor(
    command: argparse.ArgumentParser, text: str = "splats (by default), gaussians, ..."
) -> None:
    command.add_argument("--reconstructor", default="splats", help=text)
    command.add_argument("--steps", type=whole(1), help="of gaussians, which are optimised")
    text = "all cores by default; results are the same on any number"
    command.add_argument("--threads", type=whole(1), metavar="N", help=text)
