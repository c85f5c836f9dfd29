"""`fsel render`: views of a 3D Gaussian splatting `.ply`, compared with the frames there are."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace

import cv2
import numpy as np

from fsel.captures.images.film import levels
from fsel.cli import filming, posing
from fsel.cli.console import Console
from fsel.cli.request import inputs_of
from fsel.cli.scoring import columns, file_names, heading, metrics_of
from fsel.cli.selected import as_written, of_selection
from fsel.core.outputs import staged
from fsel.metrics import Metrics, score_views
from fsel.reconstruct.gaussians import GaussianModel
from fsel.selection.targets import targets_of

LONG_SIDE = 384


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    record = of_selection(args)
    if args.video is not None:
        filming.run(args, console, record)
        return
    if args.side_by_side is not None:
        raise ValueError("--side-by-side is of a video; allowed with: --video")
    read, metrics = [*inputs_of(args), args.model], metrics_of(args, console)
    with staged(args.out, read, args.force) as stage:
        model = GaussianModel.read_ply(args.model)
        console.say("model", f"{model.primitives} Gaussians, harmonics of degree {model.degree}")
        opened = posing.opened(args, console, args.long_side or LONG_SIDE)
        opened = replace(opened, capture=as_written(opened.capture, record))
        targets = targets_of(opened.capture, args.targets)
        console.say("capture", f"{len(opened.capture)} frames, {opened.layout}; {targets.kind}")
        truth = None
        if len(targets.frames):
            truth = opened.loaded(targets.frames, console.bar("images")).images
        names = _names(opened.capture.names, targets.frames, len(targets.views))
        (stage / "renders").mkdir()
        rows = []
        for t in console.bar("rendering")(range(len(names)), len(names)):
            image = model.render(targets.views.subset(slice(t, t + 1)))
            bright = levels(image[0])
            cv2.imwrite(str(stage / "renders" / f"{names[t]}.png"), bright[..., ::-1])
            row: dict[str, str | float] = {"view": names[t]}
            if truth is not None:
                scores = score_views(image, np.asarray(truth[t : t + 1]), None, metrics)[0]
                row |= dict(zip(metrics, scores.round(5).tolist(), strict=True))
            rows.append(row)
        measured = metrics if truth is not None else ()
        content = _content(args, model, targets.views.size, rows, measured)
        (stage / "render.json").write_text(json.dumps(content, indent=1), encoding="utf-8")
        table = _table(rows, content["mean"], measured)
        (stage / "render.txt").write_text(table, encoding="utf-8")
    console.text(table)
    console.say("written", f"{args.out}: render.json, render.txt, renders")
    console.give(content)


def _names(known: tuple[str, ...], frames: np.ndarray, views: int) -> list[str]:
    """Names of the views: of the frames that they are, else by number."""
    if not len(frames):
        return [f"view_{t:03d}" for t in range(views)]
    return file_names([known[frame] for frame in frames])


def _content(
    args: argparse.Namespace,
    model: GaussianModel,
    size: tuple[int, int],
    rows: list[dict],
    metrics: Metrics,
) -> dict:
    """Content of render.json; the means are null where there is no truth, and no metrics."""
    means = {name: round(float(np.mean([r[name] for r in rows])), 5) for name in metrics}
    return {
        "model": str(args.model.resolve()),
        "capture": str(args.capture.resolve()),
        "size": list(size),
        "primitives": model.primitives,
        "mean": means or None,
        "views": rows,
    }


def _table(rows: list[dict], means: dict | None, metrics: Metrics) -> str:
    """The metrics, one row a view; or the views' names."""
    if means is None:
        return "".join(f"{row['view']}\n" for row in rows)
    wide = max(len(row["view"]) for row in [*rows, {"view": "mean"}])
    lines = [f"{'view':{wide}}  {heading(metrics)}"]
    for row in [*rows, {"view": "mean", **means}]:
        lines.append(f"{row['view']:{wide}}  {columns(row, metrics)}")
    return "\n".join([*lines, ""])
