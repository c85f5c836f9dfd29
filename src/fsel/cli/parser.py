"""The command line's grammar; each command's module is imported when it runs."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from importlib import import_module
from pathlib import Path


def parser() -> argparse.ArgumentParser:
    """All commands with their options."""
    root = argparse.ArgumentParser(
        prog="fsel",
        description="Choose the frames of a posed capture that a novel-view reconstructor "
        "should be fed.",
    )
    commands = root.add_subparsers(required=True, metavar="COMMAND")
    _add_select(commands)
    return root


def _command(commands, name: str, text: str) -> argparse.ArgumentParser:
    """A command with the options that all share."""
    command = commands.add_parser(name, help=text, description=text)
    command.add_argument("capture", type=Path, help="folder of the capture")
    command.add_argument(
        "--layout", default="auto", help="how the folder is laid out; recognised by default"
    )
    command.add_argument("--quiet", action="store_true", help="print nothing but errors")
    command.add_argument("--json", action="store_true", help="print the result as JSON")
    command.set_defaults(command=_deferred(name))
    return command


def _deferred(name: str) -> Callable:
    def run(asked: argparse.Namespace, console) -> None:
        import_module(f"fsel.cli.{name}").run(asked, console)

    return run


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
    thing = command.add_mutually_exclusive_group()
    thing.add_argument(
        "--masks",
        type=Path,
        help="folder of object masks, named like the frames: targets that "
        "see the object, and features measured around it",
    )
    thing.add_argument(
        "--box",
        type=float,
        nargs=6,
        metavar=("X0", "Y0", "Z0", "X1", "Y1", "Z1"),
        help="the same for a box in world units",
    )
    command.add_argument("--seed", type=int, default=0, help="of methods that draw at random")


def _add_select(commands) -> None:
    command = _command(
        commands, "select", "Pick the frames that best serve the views to be rendered."
    )
    command.add_argument("-k", type=int, required=True, help="how many frames")
    _add_request(command)
    command.add_argument("--method", default="fsel", help="fsel, uniform, fvs, nearest, ...")
    command.add_argument(
        "--geometry-only", action="store_true", help="do not look at the images' sharpness"
    )
    command.add_argument(
        "--copy", action="store_true", help="copy the images instead of linking them"
    )
    _add_output(command, "folder to write")
