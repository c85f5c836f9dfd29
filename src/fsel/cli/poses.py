"""`fsel poses`: a capture with the poses that COLMAP finds in a video or in photos."""

from __future__ import annotations

import argparse
import shutil

from fsel.captures.opening import found_poses
from fsel.captures.poses.kept import CAPTURE, FOUND
from fsel.cli.console import Console
from fsel.cli.open_capture import inputs_of, opening_of
from fsel.core.outputs import staged

PARTS = ("images", "sparse")


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    with staged(args.out, inputs_of(args), args.force) as stage:
        place, _ = found_poses(opening_of(args), console)
        with console.clock("writing"):
            for file in (f for part in PARTS for f in (place / CAPTURE / part).rglob("*")):
                if file.is_file():  # one by one: the error of a tree's copy has no words
                    copy = stage / file.relative_to(place / CAPTURE)
                    copy.parent.mkdir(parents=True, exist_ok=True)
                    shutil.copy(file, copy)
            shutil.copy(place / FOUND, stage / FOUND)
    console.say("written", f"{args.out}: images, sparse/0, {FOUND}")
    console.give({"capture": str(args.out), "poses": str(args.out / FOUND)})
