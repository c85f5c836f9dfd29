"""`fsel reconstruct`: a model of some frames as a standard 3D Gaussian splatting `.ply`."""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from fsel.cli import posing
from fsel.cli.console import Console
from fsel.cli.optimising import WRITE_PLY, bound, checked, fitted
from fsel.cli.request import inputs_of
from fsel.outputs.atomic import staged
from fsel.request.targets import named_in
from fsel.utils.wording import counted

ENDING = ".ply"


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    checked(args)
    if args.reconstructor not in WRITE_PLY:
        raise ValueError(
            f"reconstructor {args.reconstructor!r} has no .ply to write; allowed: "
            f"{', '.join(WRITE_PLY)}"
        )
    if args.out.suffix.lower() != ENDING:
        raise ValueError(f"{args.out}: a model is written as {ENDING}. Hint: -o NAME{ENDING}")
    with staged(args.out, "reconstruct", inputs_of(args), args.force, folder=False) as stage:
        opened = posing.opened(args, console, args.long_side)
        frames = named_in(args.frames, opened.capture)
        if len(frames) < 2:
            raise ValueError(f"{args.frames}: names one frame; two or more are needed")
        loaded = opened.loaded(frames, console.bar("images"))
        console.say("capture", f"{len(frames)} of {len(opened.capture)} frames, {opened.layout}")
        model: Any = fitted(bound(args, loaded), np.arange(len(frames)), console)
        model.export_ply(stage)
    content = {
        "reconstructor": args.reconstructor,
        "frames": list(loaded.names),
        "size": list(loaded.size),
        "primitives": model.primitives,
        "seconds": round(model.seconds, 4),
        "peak_bytes": model.peak_bytes,
        "device": model.device,
    }
    steps = ""
    if hasattr(model, "steps"):
        content["steps"] = model.steps
        steps = f" in {counted(model.steps, 'step')}"
    console.say(
        "written",
        f"{args.out}: {model.primitives} Gaussians, fitted{steps} in {model.seconds:.1f} s",
    )
    console.give(content)
