"""`fsel reconstruct`: splats of some frames as a standard `.ply`."""

from __future__ import annotations

import argparse

import numpy as np

from fsel import api
from fsel.cli.console import Console
from fsel.cli.request import inputs_of
from fsel.export.records import PlyRecord
from fsel.export.staging import staged
from fsel.layouts.opening import open_capture
from fsel.request.targets import named_in


def run(asked: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    with staged(asked.out, "reconstruct", PlyRecord(), inputs_of(asked), asked.force) as stage:
        opened = open_capture(asked.capture, asked.layout, asked.long_side)
        frames = named_in(asked.frames, opened.capture)
        loaded = opened.loaded(frames, console.bar("images"))
        console.say("capture", f"{len(frames)} of {len(opened.capture)} frames, {opened.layout}")
        with console.clock("reconstructing"):
            model = api.fit(loaded, np.arange(len(frames)))
        model.export_ply(stage)
    console.say(
        "written", f"{asked.out}: {model.primitives} splats, fitted in {model.seconds:.1f} s"
    )
    console.give(
        {
            "frames": list(loaded.names),
            "size": list(loaded.size),
            "splats": model.primitives,
            "seconds": round(model.seconds, 4),
        }
    )
