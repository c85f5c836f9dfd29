"""Options that several commands share."""

from __future__ import annotations

import argparse
from pathlib import Path

from fsel.cli.values import Captures, positive, whole
from fsel.core.limits import MAX_ERROR

LARGEST = 16384  # pixels of a working image's longer side
OPENING = {
    "poses": "layout",
    "features": None,
    "video_frames": None,
    "rate": None,
    "layout": "auto",
    "max_error": MAX_ERROR,
    "skip_unreadable": False,
}
"""What `add_opening` adds, and what they are where a command line does not say."""


def bare_command(commands, name: str, text: str) -> argparse.ArgumentParser:
    """A command with the options that all share."""
    command = commands.add_parser(name, help=text, description=text)
    command.add_argument("--quiet", action="store_true", help="print nothing but errors")
    command.add_argument("--json", action="store_true", help="print the result as JSON")
    command.set_defaults(command=name)
    return command


def capture_command(commands, name: str, text: str, model: bool = False) -> argparse.ArgumentParser:
    """A command with the options of those that read a capture, or a model and a capture."""
    command = bare_command(commands, name, text)
    if model:
        command.add_argument("model", type=Path, help="3D Gaussian splatting .ply")
        command.add_argument(
            "--capture", type=Path, required=True, help="folder of the capture, in its world frame"
        )
    else:
        add_captures(command, "folder of the capture; or videos and folders of photos of one scene")
    add_opening(command)
    return command


def add_opening(command: argparse.ArgumentParser) -> None:
    """Add options of how a folder or a video becomes a capture with poses."""
    command.set_defaults(beside=[], by=None)
    command.add_argument(
        "--poses",
        choices=("layout", "colmap"),
        default=OPENING["poses"],
        help="the capture's own (by default), or those that COLMAP finds in its images alone",
    )
    add_features(command)
    add_video(command)
    add_reading(command)


def add_captures(command: argparse.ArgumentParser, text: str) -> None:
    """Add what is read: a capture, or several whose poses are found together."""
    command.add_argument("capture", type=Path, nargs="+", action=Captures, help=text)


def add_reading(command: argparse.ArgumentParser) -> None:
    """Add options of how a folder is read."""
    command.add_argument(
        "--layout",
        default=OPENING["layout"],
        help="how the folder is laid out; recognised by default",
    )
    command.add_argument(
        "--max-error",
        type=positive,
        metavar="SHARE",
        default=OPENING["max_error"],
        help="greatest median disagreement of poses and images, as a share of the images' longer "
        f"side, {MAX_ERROR} by default",
    )
    add_skipping(command)


def add_skipping(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--skip-unreadable",
        action="store_true",
        help="leave out frames whose image is missing or unreadable, and say which",
    )


def add_features(command: argparse._ActionsContainer) -> None:
    command.add_argument(
        "--features",
        choices=("sift", "xfeat", "aliked"),
        help="what COLMAP matches: SIFT by default; networks' are for what it does not place",
    )


def add_video(command: argparse.ArgumentParser) -> None:
    """Add options of how a video is thinned."""
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
        help="of a video: stretches a second instead; 4 by default, and 100 to 300 in all (three "
        "for each frame to pick, where that is more)",
    )


def add_output(command: argparse.ArgumentParser, text: str):
    """Add an output, and return the group for what may stand in its place."""
    command.add_argument("--force", action="store_true", help="replace what is there")
    place = command.add_mutually_exclusive_group(required=True)
    place.add_argument("-o", "--out", type=Path, help=text)
    return place


def add_request(command: argparse.ArgumentParser) -> None:
    """Add options of what is to be rendered."""
    command.add_argument(
        "--targets",
        metavar="WHAT",
        help="the views to be rendered: path.json (a camera path), names.txt (frames, one a line, "
        "held out), every:N (every N-th frame, held out), orbit, or trajectory; without it, "
        "anything that the capture saw",
    )
    add_keeping(command)
    add_object(command, "targets that see the object, and features measured around it")


def add_checking(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--check-poses",
        action="store_true",
        help="match every frame with two beside it, to find misplaced ones of a capture without "
        "points; some tenths of a second a frame",
    )


def add_keeping(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--keep-bad",
        action="store_true",
        help="do not look for bad frames (blurred, misplaced, wrongly exposed, covered), and let "
        "them be picked",
    )
    add_checking(command)


def add_object(command: argparse.ArgumentParser, what: str) -> None:
    """An object of interest, and the seed, which methods take beside it."""
    thing = command.add_mutually_exclusive_group()
    thing.add_argument(
        "--masks",
        type=Path,
        metavar="DIR",
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
