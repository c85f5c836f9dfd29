"""`fsel demo`: a small generated capture, and its video, to try the other commands on."""

from __future__ import annotations

import argparse

from fsel.captures.images.video import write_video
from fsel.captures.layouts import colmap
from fsel.cli.console import Console
from fsel.core.outputs import staged
from fsel.synthetic import record

SCENES = {"garden": ("mipnerf360", 5)}  # family and seed; COLMAP places every frame of it
FRAMES, SIZE = 80, (320, 240)
RATE = 4.0  # frames a second, those that `fsel poses` takes of a video: all of them
VIDEO = "walk.mp4"


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    with staged(args.out, [], args.force) as stage:
        console.say("making", f"{FRAMES} frames of {args.scene}, for about a minute")
        with console.clock("generating"):
            made = record(*SCENES[args.scene], FRAMES, *SIZE)
        colmap.write(made, stage)
        write_video(stage / VIDEO, made.images, RATE)
    console.say("written", f"{args.out}: images, sparse/0, {VIDEO}")
    console.give({"capture": str(args.out), "video": str(args.out / VIDEO)})
