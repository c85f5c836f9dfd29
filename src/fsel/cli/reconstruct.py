"""`fsel reconstruct`: a model of some frames as a standard 3D Gaussian splatting `.ply`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from fsel.captures.images.video import captioned, levels
from fsel.cli import open_capture
from fsel.cli.console import Console
from fsel.cli.open_capture import inputs_of, open_as, record_of
from fsel.cli.reconstructor_args import WRITE_PLY, bound, checked, fitted
from fsel.core.capture import Capture
from fsel.core.files import atomic
from fsel.core.outputs import staged
from fsel.core.wording import counted
from fsel.reconstruct.gaussians.model import GaussianModel
from fsel.reconstruct.gaussians.settings import QUALITIES, Quality
from fsel.selection.export.forms import TRANSFORMS
from fsel.selection.export.subset import TRAIN
from fsel.selection.frames import named_in

ENDING = ".ply"
FINE = "gaussians"  # the reconstructor of --quality and --preview
PICTURES = (".jpg", ".png")
LONG_SIDE = 96


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    quality = _quality_of(args)
    settings = {} if quality is None else quality.settings
    _check(args, settings)
    if args.frames is None and (args.capture / TRAIN / TRANSFORMS).is_file():
        args.capture /= TRAIN  # of a selection that holds frames out
    if args.frames is not None:
        open_as(args, record_of(args.frames.parent))
    with staged(args.out, inputs_of(args), args.force, folder=False) as stage:
        opened = open_capture.opened(args, console, args.long_side)
        frames = np.arange(len(opened.capture))
        if args.frames is not None:
            frames = named_in(args.frames, opened.capture)
        if len(frames) < 2:
            raise ValueError(f"{args.frames}: names one frame; two or more are needed")
        loaded = opened.loaded(frames, console.bar("images"))
        console.say("capture", f"{len(frames)} of {len(opened.capture)} frames, {opened.layout}")
        if quality is not None:
            console.say("quality", str(quality))
        watch = None if args.preview is None else _painter(loaded, args.preview)
        reconstructor = bound(args, loaded, **settings)
        model: Any = fitted(reconstructor, np.arange(len(frames)), console, watch)
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


def _check(args: argparse.Namespace, settings: dict[str, int]) -> None:
    """Refuse a reconstructor without a model to write, and names with other endings."""
    checked(args, **settings)
    if args.reconstructor not in WRITE_PLY:
        raise ValueError(
            f"reconstructor {args.reconstructor!r} has no .ply to write; allowed: "
            f"{', '.join(WRITE_PLY)}"
        )
    if args.out.suffix.lower() != ENDING:
        raise ValueError(f"{args.out}: a model is written as {ENDING}. Hint: -o NAME{ENDING}")
    if args.preview is None:
        return
    if args.reconstructor != FINE:
        raise ValueError(f"--preview shows {FINE} as they train. Hint: --reconstructor {FINE}")
    if args.preview.suffix.lower() not in PICTURES:
        raise ValueError(f"{args.preview}: a preview ends in {', '.join(PICTURES)}")
    if args.preview.exists() and not args.force:
        raise FileExistsError(f"{args.preview}: exists already. Hint: --force replaces it")


def _quality_of(args: argparse.Namespace) -> Quality | None:
    """Return the quality of --quality, and set the reconstructor and the size that belong to it.

    Raises:
        ValueError: for options that it stands for.
    """
    quality = None if args.quality is None else QUALITIES[args.quality]
    if quality is not None:
        stated = {"--steps": args.steps, "--long-side": args.long_side}
        if args.reconstructor not in (None, FINE):
            stated["--reconstructor"] = args.reconstructor
        for option, value in stated.items():
            if value is not None:
                raise ValueError(f"{option} is {value}, which --quality {args.quality} says itself")
    args.reconstructor = args.reconstructor or ("splats" if quality is None else FINE)
    args.long_side = args.long_side or (LONG_SIDE if quality is None else quality.long_side)
    return quality


def _painter(capture: Capture, path: Path) -> Callable[[GaussianModel], None]:
    """Return a function that paints the middle frame beside a model's rendering of it."""
    middle = np.array([len(capture) // 2])
    photo = np.asarray(capture.images[middle[0]])

    def paint(model: GaussianModel) -> None:
        drawn = levels(model.render(capture.view(middle))[0])
        caption = f"{capture.names[middle[0]]}, and after {counted(model.steps, 'step')}"
        image = captioned(np.hstack([photo, drawn]), caption)
        with atomic(path) as partial:
            cv2.imwrite(str(partial), image[..., ::-1])

    return paint
