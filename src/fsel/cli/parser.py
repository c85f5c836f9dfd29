"""The command line's grammar; each command's module is imported when it runs."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from decimal import Decimal
from pathlib import Path

from fsel.bounds import MAX_ERROR
from fsel.cli.values import (
    Version,
    duration,
    number_or_auto,
    numbers,
    positive,
    size_in_bytes,
    whole,
    words,
)

LARGEST = 16384  # pixels of a working image's longer side
EXPONENT = re.compile(r"-(\d+\.?\d*|\.\d+)[eE][-+]?\d{1,3}")


def parser() -> argparse.ArgumentParser:
    """All commands with their options."""
    root = argparse.ArgumentParser(
        prog="fsel",
        description="Choose the frames of a posed capture that a novel-view reconstructor "
        "should be fed.",
    )
    root.add_argument("--version", action=Version, nargs=0, help="print the version and end")
    commands = root.add_subparsers(required=True, metavar="COMMAND")
    _add_demo(commands)
    _add_poses(commands)
    _add_select(commands)
    _add_info(commands)
    _add_compare(commands)
    _add_reconstruct(commands)
    _add_render(commands)
    return root


def parsed(arguments: Sequence[str] | None) -> argparse.Namespace:
    """A command line, by default the process' own.

    Negative numbers with exponents are written out: argparse takes them for options.
    """
    given = sys.argv[1:] if arguments is None else arguments
    return parser().parse_args(
        [f"{Decimal(word):f}" if EXPONENT.fullmatch(word) else word for word in given]
    )


def _bare(commands, name: str, text: str) -> argparse.ArgumentParser:
    """A command with the options that all share."""
    command = commands.add_parser(name, help=text, description=text)
    command.add_argument("--quiet", action="store_true", help="print nothing but errors")
    command.add_argument("--json", action="store_true", help="print the result as JSON")
    command.set_defaults(command=name)
    return command


def _command(commands, name: str, text: str, model: bool = False) -> argparse.ArgumentParser:
    """A command with the options of those that read a capture, or a model and a capture."""
    command = _bare(commands, name, text)
    if model:
        command.add_argument("model", type=Path, help="3D Gaussian splatting .ply")
        command.add_argument(
            "--capture", type=Path, required=True, help="folder of the capture, in its world frame"
        )
    else:
        command.add_argument(
            "capture", type=Path, help="folder of the capture; or a video, whose poses are found"
        )
    command.add_argument(
        "--poses",
        choices=("layout", "colmap"),
        default="layout",
        help="the capture's own (by default), or those that COLMAP finds in its images alone",
    )
    _add_video(command)
    command.add_argument(
        "--layout", default="auto", help="how the folder is laid out; recognised by default"
    )
    command.add_argument(
        "--max-error",
        type=positive,
        metavar="SHARE",
        default=MAX_ERROR,
        help="greatest median disagreement of poses and images, as a share of the images' longer "
        f"side, {MAX_ERROR} by default",
    )
    return command


def _add_video(command: argparse.ArgumentParser) -> None:
    """How a video is thinned."""
    thinned = command.add_mutually_exclusive_group()
    thinned.add_argument(
        "--video-frames",
        type=whole(3, 100_000),
        metavar="N",
        help="of a video: the sharpest frame of each of N equal stretches",
    )
    thinned.add_argument(
        "--rate",
        type=positive,
        metavar="FPS",
        help="of a video: stretches a second instead; 4 by default, and 300 at most in all",
    )


def _add_output(command: argparse.ArgumentParser, text: str) -> None:
    command.add_argument("-o", "--out", type=Path, required=True, help=text)
    command.add_argument("--force", action="store_true", help="replace what an earlier run wrote")


def _add_request(command: argparse.ArgumentParser) -> None:
    """What is to be rendered."""
    command.add_argument(
        "--targets",
        metavar="WHAT",
        help="the views to be rendered: path.json (a camera path), names.txt (frames, one a line, "
        "held out), every:N (every N-th frame, held out), orbit, or trajectory; without it, "
        "anything that the capture saw",
    )
    _add_object(command, "targets that see the object, and features measured around it")


def _add_object(command: argparse.ArgumentParser, what: str) -> None:
    """An object of interest, and the seed, which methods take beside it."""
    thing = command.add_mutually_exclusive_group()
    thing.add_argument(
        "--masks",
        type=Path,
        help=f"folder of object masks, named like the frames: {what}",
    )
    thing.add_argument(
        "--box",
        type=float,
        nargs=6,
        metavar=("X0", "Y0", "Z0", "X1", "Y1", "Z1"),
        help="the same for a box in world units",
    )
    command.add_argument("--seed", type=whole(0), default=0, help="of methods that draw at random")


def _add_demo(commands) -> None:
    command = _bare(commands, "demo", "Generate a small capture, and its video, to try fsel on.")
    command.add_argument("scene", choices=("garden",), help="what it shows: garden")
    _add_output(command, "folder to write")


def _add_poses(commands) -> None:
    text = "Find the poses of a video or of photos with COLMAP, and write them as a capture."
    command = _bare(commands, "poses", text)
    command.add_argument("capture", type=Path, help="video, or folder of photos")
    _add_video(command)
    _add_output(command, "folder to write")


def _add_select(commands) -> None:
    command = _command(
        commands, "select", "Pick the frames that best serve the views to be rendered."
    )
    command.add_argument(
        "-k",
        type=number_or_auto,
        required=True,
        help="how many frames, or auto: until more are predicted to gain too little",
    )
    command.add_argument(
        "--refine",
        type=duration,
        metavar="TIME",
        help="then try swaps of the picks for so long, as 10s or 2m, judged by reconstructions of "
        "this capture; Ctrl-C keeps the best so far",
    )
    command.add_argument(
        "--threshold",
        type=positive,
        metavar="DB",
        help="of -k auto: least PSNR that further frames must gain each, 0.02 by default",
    )
    command.add_argument(
        "--memory",
        type=size_in_bytes,
        metavar="SIZE",
        help="of -k auto: bytes that the splats of a reconstruction may take, as 500MB or 2GiB",
    )
    _add_size(command, "of --memory: ")
    _add_request(command)
    command.add_argument("--method", help="fsel (by default), ours, uniform, fvs, nearest, ...")
    command.add_argument(
        "--weights",
        type=Path,
        metavar="FILE",
        help="a scorer that fsel train or the workflow made, .safetensors or .json; it says the "
        "method",
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
    command.add_argument(
        "--geometry-only",
        action="store_true",
        help="do not open images: no sharpness, no pictures in the report",
    )
    command.add_argument(
        "--copy", action="store_true", help="copy the images instead of linking them"
    )
    _add_output(command, "folder to write")


def _add_info(commands) -> None:
    _command(commands, "info", "Say what a capture holds, and how many frames seem worth keeping.")


def _add_compare(commands) -> None:
    command = _command(
        commands,
        "compare",
        "Reconstruct from what several methods pick, and compare renderings with held-out frames.",
    )
    command.add_argument(
        "-k", type=numbers, default=[10, 20, 30], help="numbers of frames, 10,20,30 by default"
    )
    command.add_argument(
        "--methods",
        type=words,
        default=["fsel", "uniform", "fvs"],
        help="names, fsel,uniform,fvs by default",
    )
    command.add_argument(
        "--targets",
        metavar="WHAT",
        default="every:8",
        help="the frames that are held out and compared with: every:N (every N-th; every:8 by "
        "default), or names.txt (one a line)",
    )
    _add_object(command, "frames that see the object, compared inside of their masks")
    _add_reconstructor(command)
    _add_metrics(command)
    _add_size(command)
    _add_output(command, "folder to write")


def _add_reconstruct(commands) -> None:
    command = _command(commands, "reconstruct", "Write a model of some frames as a 3DGS .ply.")
    command.add_argument(
        "--frames", type=Path, required=True, help="file with a frame name a line, as frames.txt"
    )
    _add_reconstructor(command)
    _add_size(command)
    _add_output(command, "file to write")


def _add_render(commands) -> None:
    command = _command(
        commands,
        "render",
        "Render a 3DGS .ply, and compare it with the frames of a capture.",
        model=True,
    )
    command.add_argument(
        "--targets",
        metavar="WHAT",
        required=True,
        help="the views: every:N or names.txt (frames, which are compared), path.json, orbit or "
        "trajectory (which have no truth to compare with)",
    )
    _add_metrics(command)
    _add_size(command, default=384)
    _add_output(command, "folder to write")


def _add_metrics(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--lpips-weights",
        type=Path,
        metavar="FILE",
        help="measure LPIPS in place of GMSD, with the ImageNet weights of its backbone",
    )
    command.add_argument("--lpips-net", help="its backbone: vgg (by default), alex or squeeze")


def _add_reconstructor(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--reconstructor", default="splats", help="splats (by default), gaussians, ..."
    )
    command.add_argument(
        "--steps", type=whole(1), help="of a reconstructor that optimises, as gaussians"
    )


def _add_size(command: argparse.ArgumentParser, what: str = "", default: int = 96) -> None:
    command.add_argument(
        "--long-side",
        type=whole(1, LARGEST),
        default=default,
        help=f"{what}longer side in pixels of the images, {default} by default",
    )
