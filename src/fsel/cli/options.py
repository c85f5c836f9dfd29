"""Options that several commands share, and the types of their values."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fsel.core.limits import MAX_ERROR

NUMBER = r"\d+\.?\d*|\.\d+"
SIZE = re.compile(rf"({NUMBER})\s*([kmgt]?)(i?)b?", re.IGNORECASE)
DURATION = re.compile(rf"(?:(\d+):)?({NUMBER})\s*(s|m|min|h)?")
SECONDS = {None: 1, "s": 1, "m": 60, "min": 60, "h": 3600}
POWERS = {"": 0, "k": 1, "m": 2, "g": 3, "t": 4}
LARGEST = 16384  # pixels of a working image's longer side
UNPOSED = "none"  # of --poses
OPENING = {
    "poses": "layout",
    "features": None,
    "pose_time": None,
    "pose_masks": None,
    "video_frames": None,
    "rate": None,
    "start": 0.0,
    "end": None,
    "layout": "auto",
    "max_error": MAX_ERROR,
    "skip_unreadable": False,
}
"""What `add_opening` adds, and what they are where a command line does not say."""
EXAMPLES = {
    "demo": "garden -o captures/garden",
    "poses": "walk.mp4 -o walked",
    "select": "walk.mp4 -k 30 -o walk30",
    "info": "captures/garden",
    "compare": "captures/garden -k 10,20 -o compared",
    "reconstruct": "walk30 -o walk.ply",
    "render": "walk.ply --capture walk30 --targets orbit --video orbit.mp4",
    "view": "walk.ply walk30 -o walk.html",
    "cache": "--clear",
}


def whole(least: int, most: int | None = None) -> Callable[[str], int]:
    """Return the type of a whole number between two bounds, both included."""

    allowed = f"{least} or more" if most is None else f"{least} to {most}"

    def integer(text: str) -> int:
        value = _read(int, text, f"a whole number, {allowed}")
        if value < least or (most is not None and value > most):
            raise argparse.ArgumentTypeError(f"{text} is out of range; allowed: {allowed}")
        return value

    return integer


def _read(kind: Callable[[str], Any], text: str, allowed: str) -> Any:
    """Read a number of a kind."""
    try:
        return kind(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r} is no number; allowed: {allowed}") from error


def number_or_auto(text: str) -> int | str:
    """Read a whole number, or `auto`."""
    return text if text == "auto" else _read(int, text, "a whole number, or auto")


def numbers(text: str) -> list[int]:
    """Read whole numbers between commas, each once, ascending."""
    allowed = "whole numbers between commas"
    return sorted({_read(int, word, allowed) for word in text.split(",")})


def words(text: str) -> list[str]:
    """Read words between commas, each once, without the spaces around them."""
    names = list(dict.fromkeys(word.strip() for word in text.split(",") if word.strip()))
    if not names:
        raise argparse.ArgumentTypeError(f"{text!r} is empty; allowed: names separated by commas")
    return names


def positive(text: str) -> float:
    """Read a number above zero."""
    number = _read(float, text, "more than 0")
    if not number > 0:
        raise argparse.ArgumentTypeError(f"{text!r} is out of range; allowed: more than 0")
    return number


def size_in_bytes(text: str) -> int:
    """Read 8GB, 500M (powers of 1000), 8GiB, 500MiB (powers of 1024), or plain bytes."""
    parts = SIZE.fullmatch(text.strip())
    if parts is None or (parts[3] and not parts[2]) or not float(parts[1]) > 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a size; allowed: 8GB, 500M, 8GiB, ...")
    return int(float(parts[1]) * (1024 if parts[3] else 1000) ** POWERS[parts[2].lower()])


def duration(text: str) -> float:
    """Read 10s, 2m, 2min, 1h, 1:23, or plain seconds; 0 for none."""
    parts = DURATION.fullmatch(text.strip())
    if parts is None:
        raise argparse.ArgumentTypeError(f"{text!r} is no time; allowed: as 10s, 2m, 1:23, 0")
    return 60 * float(parts[1] or 0) + float(parts[2]) * SECONDS[parts[3]]


def bare_command(commands, name: str, text: str) -> argparse.ArgumentParser:
    """Add a command with the options that all share."""
    example = f"example: fsel {name} {EXAMPLES[name]}"
    command = commands.add_parser(name, help=text, description=text, epilog=example)
    command.add_argument("--quiet", action="store_true", help="print only errors")
    command.add_argument("--json", action="store_true", help="print the result as JSON")
    command.set_defaults(command=name)
    return command


def capture_command(commands, name: str, text: str) -> argparse.ArgumentParser:
    """Add a command that reads a capture, with the options of how it is opened."""
    command = bare_command(commands, name, text)
    add_captures(command)
    add_opening(command.add_argument_group("input"))
    return command


def add_captures(command: argparse.ArgumentParser) -> None:
    """Add what is read: a capture, or several parts whose poses are found together."""
    command.add_argument("capture", type=Path, help="folder of a capture or of photos, or a video")
    text = "more videos and folders of photos of the same scene"
    command.add_argument("beside", metavar="more", type=Path, nargs="*", default=[], help=text)


def add_opening(command: argparse._ActionsContainer, unposed: bool = False) -> None:
    """Add options of how a folder or a video becomes a capture with poses, or does without."""
    command.set_defaults(by=None, mask_by=None, pose_masks=None)
    text = "use the capture's poses (default), or estimate them with COLMAP"
    text += "; none (or --no-poses) to write no cameras" if unposed else ""
    kinds, usual = ("layout", "colmap", *([UNPOSED] if unposed else [])), OPENING["poses"]
    command.add_argument("--poses", choices=kinds, default=usual, help=text)
    if unposed:
        const: dict[str, Any] = {"action": "store_const", "const": UNPOSED}
        command.add_argument("--no-poses", dest="poses", **const, help=argparse.SUPPRESS)
    add_features(command)
    add_video(command, not unposed)
    text = "layout of the folder (default: recognised)"
    command.add_argument("--layout", default=OPENING["layout"], help=text)
    command.add_argument(
        "--max-error",
        type=positive,
        metavar="SHARE",
        default=OPENING["max_error"],
        help="largest median disagreement of poses and images allowed, as a share of the images' "
        f"longer side (default: {MAX_ERROR})",
    )
    add_skipping(command)


def add_features(command: argparse._ActionsContainer) -> None:
    text = "features that COLMAP matches (default: sift); the network aliked may place more frames"
    command.add_argument("--features", choices=("sift", "aliked"), help=text)
    text = (
        "time for estimating poses, such as 2m, after which what is placed is used (default: what "
        "the first try leaves out is searched for three times as long)"
    )
    command.add_argument("--pose-time", type=duration, metavar="TIME", help=text)


def add_video(command: argparse._ActionsContainer, most_frames: bool = True) -> None:
    """Add options of how a video is thinned."""
    thinned = command.add_mutually_exclusive_group()
    if most_frames:
        text = "video: take the sharpest frame of each of N equal intervals"
        thinned.add_argument("--video-frames", type=whole(3, 100_000), metavar="N", help=text)
    text = (
        "video: frames to sample per second (default: up to 4, as the camera moves; 60 to "
        "300 in all, or three per frame to pick if that is more)"
    )
    thinned.add_argument("--rate", type=positive, metavar="FPS", help=text)
    text = "video: start at this time, such as 83 or 1:23 (--end TIME stops there)"
    command.add_argument("--start", type=duration, metavar="TIME", default=0.0, help=text)
    text = "video: stop at this time" if most_frames else argparse.SUPPRESS
    command.add_argument("--end", type=duration, metavar="TIME", help=text)


def add_skipping(command: argparse._ActionsContainer) -> None:
    text = "skip and report frames whose image is missing or unreadable"
    command.add_argument("--skip-unreadable", action="store_true", help=text)


def add_output(command: argparse.ArgumentParser, text: str):
    """Add an output, and return the group for what may stand in its place."""
    command.add_argument("--force", action="store_true", help="replace an existing output")
    place = command.add_mutually_exclusive_group(required=True)
    place.add_argument("-o", "--out", type=Path, help=text)
    return place


def add_threads(
    command: argparse.ArgumentParser, effect: str = "only estimated poses depend on it"
) -> None:
    text = f"number of threads (default: all cores); {effect}"
    command.add_argument("--threads", type=whole(1), metavar="N", help=text)


def add_keeping(command: argparse._ActionsContainer) -> None:
    text = (
        "skip the search for bad frames (blurred, misplaced, badly exposed) and allow them as picks"
    )
    command.add_argument("--keep-bad", action="store_true", help=text)


class Masks(argparse.Action):
    """Masks of an object, or, as `poses:DIR`, those that features are kept to."""

    def __call__(self, parser, namespace, values, option_string=None) -> None:
        """Store one of the two."""
        kind, stated, folder = values.partition(":")
        if stated and kind == "poses":
            namespace.pose_masks = str(Path(folder).resolve())
        else:
            namespace.masks = Path(values)


def add_object(command: argparse._ActionsContainer, what: str) -> None:
    """Add an object of interest."""
    thing = command.add_mutually_exclusive_group()
    text = f"folder of object masks named like the frames: {what}; poses:DIR has masks for COLMAP"
    thing.add_argument("--masks", action=Masks, metavar="DIR", help=text)
    corners = ("X0", "Y0", "Z0", "X1", "Y1", "Z1")
    text = "the same with a box in world units"
    thing.add_argument("--box", type=float, nargs=6, metavar=corners, help=text)


def add_size(command: argparse.ArgumentParser, default: int | None, usual: str = "") -> None:
    """Add the images' size; `usual` says the default that depends on other options."""
    text = f"longer side of the images in pixels (default: {usual or default})"
    command.add_argument("--long-side", type=whole(1, LARGEST), default=default, help=text)
