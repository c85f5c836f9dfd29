"""`fsel render --video`: a flight through a model, or through two side by side."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator

import numpy as np

from fsel.captures.images import film
from fsel.cli import posing
from fsel.cli.console import Console
from fsel.cli.request import inputs_of
from fsel.cli.selected import as_written
from fsel.core.capture import Views
from fsel.core.names import distinct
from fsel.core.outputs import staged
from fsel.reconstruct.gaussians import GaussianModel
from fsel.selection.flights import flight

ENDING = ".mp4"
RATE = 30  # frames a second
LONG_SIDE = 1280


def run(args: argparse.Namespace, console: Console, record: dict) -> None:
    """Carry the command out; the record is that of `of_selection`."""
    if args.video.suffix.lower() != ENDING:
        raise ValueError(f"{args.video}: a video is written as {ENDING}. Hint: NAME{ENDING}")
    if args.metrics:
        raise ValueError("--metrics compares renderings with frames; allowed with: -o")
    files = [args.model] if args.side_by_side is None else [args.model, args.side_by_side]
    with staged(args.video, [*inputs_of(args), *files], args.force, folder=False) as stage:
        names = distinct([file.stem for file in files])
        models = {
            name: GaussianModel.read_ply(file) for name, file in zip(names, files, strict=True)
        }
        capture = as_written(posing.opened(args, console).capture, record)
        count, long_side = max(round(args.seconds * RATE), 1), args.long_side or LONG_SIDE
        views = flight(capture, args.targets, count, long_side)
        started = time.perf_counter()
        rows = console.bar("rendering")(range(len(views)), len(views))
        film.write(stage, _frames(models, views, rows), RATE)
        each = (time.perf_counter() - started) / len(views)
    width, height = views.size
    said = f"{len(views)} frames of {len(models)} x {width}x{height}, {each:.2f} s each"
    console.say("written", f"{args.video}: {said}")
    console.give(
        {"video": str(args.video.resolve()), "frames": len(views), "size": [width, height]}
    )


def _frames(models: dict[str, GaussianModel], views: Views, rows) -> Iterator[np.ndarray]:
    """Every view of each model, side by side; captions tell two apart."""
    for row in rows:
        view = views.subset(slice(row, row + 1))
        panels = {name: film.levels(model.render(view)[0]) for name, model in models.items()}
        if len(panels) > 1:
            panels = {name: film.captioned(image, name) for name, image in panels.items()}
        yield np.hstack(list(panels.values()))
