"""The command line's grammar; each command's module is imported when it runs."""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Sequence
from decimal import Decimal
from importlib.metadata import version
from pathlib import Path
from typing import Any, NoReturn

from fsel.cli.options import (
    add_captures,
    add_features,
    add_keeping,
    add_object,
    add_opening,
    add_output,
    add_size,
    add_skipping,
    add_threads,
    add_video,
    bare_command,
    capture_command,
    numbers,
    positive,
    whole,
    words,
)
from fsel.cli.select_options import add_select
from fsel.core.registry import closest

EXPONENT = re.compile(r"-(\d+\.?\d*|\.\d+)[eE][-+]?\d{1,3}")


class Parser(argparse.ArgumentParser):
    """A parser whose refusals are short, and name the command or the option that was meant."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings, add_help=False)
        self.add_argument("-h", "--help", action="help", help=argparse.SUPPRESS)
        self._given: list[str] = []

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Parse as usual; what is left over is refused here, by the command that it was given."""
        self._given = sys.argv[1:] if args is None else list(args)
        found, left = super().parse_known_args(args, namespace)
        if left:
            self.error(f"unrecognized arguments: {' '.join(left)}")
        return found, left

    def error(self, message: str) -> NoReturn:
        """Print the usage in a line, and what is wrong, and exit with code 2."""
        placed = [a for a in self._actions if not a.option_strings and a.nargs != "*"]
        places = [str(action.metavar or action.dest.upper()) for action in placed]
        usage = " ".join(
            ["usage:", self.prog, *places, f"[options]; {self.prog} --help lists them"]
        )
        near = self._meant()
        hint = f". Did you mean {near}?" if near else ""
        self.exit(2, f"{usage}\n{self.prog}: error: {message}{hint}\n")

    def _meant(self) -> str:
        """Return the command or option most like the first word that is none."""
        words = [word.partition("=")[0] for word in self._given]
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                named = next((word for word in words if not word.startswith("-")), "")
                return "" if named in action.choices else closest(named, action.choices)
        known = [name for action in self._actions for name in action.option_strings]
        long = [word for word in words if word.startswith("--") and word != "--"]
        strange = [word for word in long if not any(name.startswith(word) for name in known)]
        return closest(strange[0], known) if strange else ""


def parser() -> argparse.ArgumentParser:
    """Return the grammar of all commands."""
    root = Parser(
        prog="fsel",
        description="Choose the frames of a video or capture from which a novel-view "
        "reconstructor gives the best renderings.",
    )
    root.add_argument("--version", action="version", version=f"fsel {version('fsel')}")
    commands = root.add_subparsers(required=True, metavar="COMMAND")
    text = "Generate a small capture and its video to try fsel on."
    demo = bare_command(commands, "demo", text)
    demo.add_argument("scene", choices=("garden",), help="the scene to generate")
    add_output(demo, "folder to write")
    _add_poses(commands)
    add_select(commands)
    text = "Describe a capture, find its bad frames, and suggest how many frames to keep."
    info = capture_command(commands, "info", text)
    add_threads(info)
    _add_compare(commands)
    _add_reconstruct(commands)
    _add_render(commands)
    _add_view(commands)
    text = "List what is kept in the user's cache: found poses, weights, compiled code."
    kept = bare_command(commands, "cache", text)
    kept.add_argument("--clear", action="store_true", help="remove it")
    return root


def parsed(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Parse a command line, by default the process' own.

    Negative numbers with exponents are written out: argparse takes them for options.
    """
    given = sys.argv[1:] if arguments is None else arguments
    words = [f"{Decimal(word):f}" if EXPONENT.fullmatch(word) else word for word in given]
    grammar = parser()
    if "_ARGCOMPLETE" in os.environ:  # set by the shell's completion alone
        from argcomplete import autocomplete

        autocomplete(grammar)
    return grammar.parse_args(words, argparse.Namespace(words=words))


def _add_poses(commands) -> None:
    text = "Estimate the poses of a video or photos, and write a capture."
    command = bare_command(commands, "poses", text)
    add_captures(command)
    found = command.add_mutually_exclusive_group()
    add_features(found)
    text = (
        "program that estimates the poses instead of COLMAP, as one argument, such as "
        "'python mapper.py {folder}'; repeat it to run several in turn"
    )
    found.add_argument("--by", metavar="COMMAND", action="append", help=text)
    masks = command.add_mutually_exclusive_group()
    text = "folder of masks named like the images: COLMAP matches only white areas"
    masks.add_argument("--masks", dest="pose_masks", metavar="DIR", help=text)
    text = "program that makes such masks, as one argument; see docs/cli.md"
    masks.add_argument("--mask-by", metavar="COMMAND", action="append", help=text)
    add_video(command)
    add_skipping(command)
    add_threads(command, "1 gives the same poses every time")
    add_output(command, "folder to write")


def _add_compare(commands) -> None:
    text = "Compare methods: reconstruct from their picks and score held-out frames."
    command = capture_command(commands, "compare", text)
    command.add_argument(
        "-k", type=numbers, default=[10, 20, 30], help="numbers of frames (default: 10,20,30)"
    )
    text = "methods to compare (default: tried,uniform,fsel); tried is what `fsel select -k` does"
    command.add_argument("--methods", type=words, default=["tried", "uniform", "fsel"], help=text)
    text = (
        "frames to hold out and score: every:N (every N-th frame; default: every:8), or "
        "names.txt (one name per line)"
    )
    command.add_argument("--targets", metavar="WHAT", default="every:8", help=text)
    add_keeping(command)
    add_object(command, "compare only frames that show the object, inside the masks")
    command.add_argument("--seed", type=whole(0), default=0, help="seed of random methods")
    text = "gaussians (default where all fits take two minutes of a core), splats, ..."
    _add_reconstructor(command, text)
    _add_metrics(command)
    add_size(command, default=192)
    add_output(command, "folder to write")


def _add_reconstruct(commands) -> None:
    text = "Reconstruct from selected frames, and write a 3DGS .ply."
    command = capture_command(commands, "reconstruct", text)
    text = (
        "file with one frame name per line, such as frames.txt (default: all frames, which in a "
        "folder written by `fsel select` are the picks)"
    )
    command.add_argument("--frames", type=Path, help=text)
    text = "train gaussians at 384, 640 or 960 pixels (default: draft, without the options below)"
    command.add_argument("--quality", choices=("draft", "good", "best"), help=text)
    _add_reconstructor(command, "splats or gaussians")
    add_size(command, None, "that of --quality")
    add_output(command, "file to write")


def _add_render(commands) -> None:
    text = "Render a 3DGS .ply, to score it against frames of a capture or as a video."
    command = bare_command(commands, "render", text)
    command.add_argument("model", type=Path, help="3D Gaussian splatting .ply")
    text = "capture whose world frame the .ply uses"
    command.add_argument("--capture", type=Path, required=True, help=text)
    add_opening(command.add_argument_group("input"))
    text = (
        "views to render: every:N or names.txt (frames, scored against their photos), or "
        "path.json, orbit or trajectory (rendered only)"
    )
    command.add_argument("--targets", metavar="WHAT", required=True, help=text)
    _add_metrics(command)
    add_threads(command)
    add_size(command, None, "384; 1280 for a video")
    text = "write an .mp4 that flies along the views, or from frame to frame, instead"
    place = add_output(command, "folder to write")
    place.add_argument("--video", type=Path, metavar="FILE", help=text)
    text = "length of the video at 30 frames per second (default: 5)"
    command.add_argument("--seconds", type=positive, default=5.0, help=text)
    command.set_defaults(beside=[])


def _add_view(commands) -> None:
    text = "Write a web page that shows a 3DGS .ply, or sparse points, with cameras and photos."
    command = bare_command(commands, "view", text)
    text = "a 3DGS .ply, a folder written by `fsel select`, a capture, or several of these"
    command.add_argument("source", type=Path, nargs="+", help=text)
    add_opening(command.add_argument_group("input"))
    add_size(command, default=480)
    add_output(command, ".html file to write")
    command.set_defaults(capture=None, beside=[])


def _add_metrics(command: argparse.ArgumentParser) -> None:
    text = "metrics (default: psnr,ssim,gmsd); lpips downloads its weights (64 MB) once"
    command.add_argument("--metrics", type=words, default=(), help=text)


def _add_reconstructor(command: argparse.ArgumentParser, text: str) -> None:
    command.add_argument("--reconstructor", help=text)
    command.add_argument("--steps", type=whole(1), help="optimisation steps of gaussians")
    add_threads(command)
