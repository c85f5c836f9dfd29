"""`fsel poses`: a capture with the poses that COLMAP finds in a video or in photos."""

from __future__ import annotations

import argparse
import shutil

from fsel.cli.console import Console
from fsel.cli.posing import CAPTURE, FOUND, found_poses
from fsel.cli.request import inputs_of
from fsel.outputs.atomic import staged


def run(asked: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    with staged(asked.out, "poses", inputs_of(asked), asked.force) as stage:
        place = found_poses(asked, console)
        with console.clock("writing"):
            for part in ("images", "sparse"):
                shutil.copytree(place / CAPTURE / part, stage / part)
            shutil.copy(place / FOUND, stage / FOUND)
    console.say("written", f"{asked.out}: images, sparse/0, {FOUND}")
    console.give({"capture": str(asked.out), "poses": str(asked.out / FOUND)})
