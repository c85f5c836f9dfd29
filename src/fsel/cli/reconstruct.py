"""`fsel reconstruct`: a model of some frames as a standard 3D Gaussian splatting `.ply`."""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from fsel.captures.forms import TRANSFORMS
from fsel.cli import open_capture
from fsel.cli.console import Console
from fsel.cli.open_capture import inputs_of, open_as, record_of
from fsel.cli.reconstructor_args import STEPPED, WRITE_PLY, bound, checked, stopped_by_interrupt
from fsel.core.outputs import staged
from fsel.core.wording import counted
from fsel.reconstruct import Reconstructor
from fsel.reconstruct.gaussians.settings import QUALITIES, Quality
from fsel.selection.export.subset import TRAIN
from fsel.selection.frames import is_stated, named_in

ENDING = ".ply"
FINE, DRAFT = "gaussians", "draft"  # the reconstructor of --quality, and its usual value
LONG_SIDE = 96
KEPT = "interrupted: writing the current model; press Ctrl-C again to discard it"


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    quality = _quality_of(args)
    settings = {} if quality is None else quality.settings
    _check(args, settings)
    if args.frames is not None:
        is_stated(args.frames)
        open_as(args, record_of(args.frames.parent))
    elif (args.capture / TRAIN / TRANSFORMS).is_file():
        args.capture /= TRAIN  # of a selection that holds frames out
    with staged(args.out, inputs_of(args), args.force, folder=False) as stage:
        opened = open_capture.opened(args, console, args.long_side)
        frames = np.arange(len(opened.capture))
        if args.frames is not None:
            frames = named_in(args.frames, opened.capture)
        if len(frames) < 2:
            raise ValueError(f"{args.frames}: names one frame; at least two are needed")
        loaded = opened.loaded(frames, console.bar("images"))
        console.say("capture", f"{len(frames)} of {len(opened.capture)} frames, {opened.layout}")
        if quality is not None:
            console.say("quality", str(quality))
        model = _fitted(bound(args, loaded, **settings), np.arange(len(frames)), args, console)
        model.export_ply(stage)
    steps = {"steps": model.steps} if hasattr(model, "steps") else {}
    said = "".join(f" in {counted(count, 'step')}" for count in steps.values())
    fit = f"{model.primitives} Gaussians, fitted{said} in {model.seconds:.1f} s"
    console.say("written", f"{args.out}: {fit}")
    content = {
        "reconstructor": args.reconstructor,
        "frames": list(loaded.names),
        "size": list(loaded.size),
        "primitives": model.primitives,
        "seconds": round(model.seconds, 4),
        "peak_bytes": model.peak_bytes,
        "device": model.device,
    }
    console.give(content | steps)


def _check(args: argparse.Namespace, settings: dict[str, float]) -> None:
    """Refuse a reconstructor without a model to write, and names with other endings."""
    checked(args, **settings)
    if args.reconstructor not in WRITE_PLY:
        raise ValueError(
            f"reconstructor {args.reconstructor!r} cannot write a .ply; allowed: "
            f"{', '.join(WRITE_PLY)}"
        )
    if args.out.suffix.lower() != ENDING:
        raise ValueError(f"{args.out}: a model must be a {ENDING} file. Hint: -o NAME{ENDING}")


def _quality_of(args: argparse.Namespace) -> Quality | None:
    """Return the quality of --quality, and set the reconstructor and the size that belong to it."""
    usual = (args.reconstructor, args.steps, args.long_side) == (None, None, None)
    quality = QUALITIES[args.quality or DRAFT] if usual or args.quality else None
    if quality is not None:
        stated = {"--steps": args.steps, "--long-side": args.long_side}
        if args.reconstructor not in (None, FINE):
            stated["--reconstructor"] = args.reconstructor
        for option, value in stated.items():
            if value is not None:
                raise ValueError(f"{option} is {value}, but --quality {args.quality} sets it")
    args.reconstructor = args.reconstructor or ("splats" if quality is None else FINE)
    args.long_side = args.long_side or (LONG_SIDE if quality is None else quality.long_side)
    return quality


def _fitted(
    reconstructor: Reconstructor, frames: np.ndarray, args: argparse.Namespace, console: Console
) -> Any:
    """Return a model of some frames; Ctrl-C ends its optimisation, a second Ctrl-C gives up."""
    if args.reconstructor not in STEPPED:
        with console.clock("reconstructing"):
            return reconstructor.fit(frames)
    fit: Any = reconstructor.fit
    with (
        console.steps("reconstructing") as progress,
        stopped_by_interrupt(console, KEPT) as stop,
    ):
        return fit(frames, progress=progress, stop=stop)
