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


def run(asked: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    checked(asked)
    if asked.reconstructor not in WRITE_PLY:
        raise ValueError(
            f"reconstructor {asked.reconstructor!r} has no .ply to write; allowed: "
            f"{', '.join(WRITE_PLY)}"
        )
    if asked.out.suffix.lower() != ENDING:
        raise ValueError(f"{asked.out}: a model is written as {ENDING}. Hint: -o NAME{ENDING}")
    with staged(asked.out, "reconstruct", inputs_of(asked), asked.force, folder=False) as stage:
        opened = posing.opened(asked, console, asked.long_side)
        frames = named_in(asked.frames, opened.capture)
        if len(frames) < 2:
            raise ValueError(f"{asked.frames}: names one frame; two or more are needed")
        loaded = opened.loaded(frames, console.bar("images"))
        console.say("capture", f"{len(frames)} of {len(opened.capture)} frames, {opened.layout}")
        model: Any = fitted(bound(asked, loaded), np.arange(len(frames)), console)
        model.export_ply(stage)
    content = {
        "reconstructor": asked.reconstructor,
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
        f"{asked.out}: {model.primitives} Gaussians, fitted{steps} in {model.seconds:.1f} s",
    )
    console.give(content)
