"""`fsel render`: views of a 3D Gaussian splatting `.ply`, compared with frames, or as a video."""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.spatial.transform import Rotation, RotationSpline

from fsel.captures.images.video import levels, write_video
from fsel.captures.lazy import LazyCapture
from fsel.cli import open_capture
from fsel.cli.console import Console
from fsel.cli.open_capture import inputs_of, open_of_selection
from fsel.cli.scoring import columns, heading, metrics_of
from fsel.core.capture import Capture, Views
from fsel.core.files import json_text
from fsel.core.geometry import poses_at
from fsel.core.outputs import staged
from fsel.metrics import Metrics, score_views
from fsel.reconstruct import ply
from fsel.reconstruct.gaussians import GaussianModel
from fsel.selection.targets import Request, Targets, check_targets, targets_of

LONG_SIDE, VIDEO_SIDE = 384, 1280
ENDING = ".mp4"
RATE = 30  # frames a second
STILL = 0.05  # of the mean way between two cameras: what a stop takes at least


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    check_targets(args.targets)
    open_of_selection(args)
    if args.video is not None:
        render_video(args, console)
        return
    read, metrics = [*inputs_of(args), args.model], metrics_of(args, console)
    with staged(args.out, read, args.force) as stage:
        model = _model(args.model)
        console.say("model", f"{model.primitives} Gaussians, harmonics of degree {model.degree}")
        opened = open_capture.opened(args, console, args.long_side or LONG_SIDE)
        targets = targets_of(opened.capture, args.targets)
        console.say("capture", f"{len(opened.capture)} frames, {opened.layout}; {targets.kind}")
        rows = _rendered(model, opened, targets, stage / "renders", metrics, console)
        means = None
        if len(targets.frames):
            means = {m: round(float(np.mean([row[m] for row in rows])), 5) for m in metrics}
        content = {
            "model": str(args.model.resolve()),
            "capture": str(args.capture.resolve()),
            "size": list(targets.views.size),
            "primitives": model.primitives,
            "mean": means,
            "views": rows,
        }
        (stage / "render.json").write_text(json_text(content), encoding="utf-8")
        table = _table(rows, means, metrics)
        (stage / "render.txt").write_text(table, encoding="utf-8")
    console.text(table)
    console.say("written", f"{args.out}: render.json, render.txt, renders")
    console.give(content)


def _model(path: Path) -> GaussianModel:
    """Read a model to be rendered."""
    model = GaussianModel.read_ply(path)
    ply.check_filled(path, model.primitives)
    return model


def _rendered(
    model: GaussianModel,
    opened: LazyCapture,
    targets: Targets,
    folder: Path,
    metrics: Metrics,
    console: Console,
) -> list[dict[str, str | float]]:
    """Write every view's picture, and return its metrics where there is a frame to compare with."""
    names, truth = [f"view_{t:03d}" for t in range(len(targets.views))], None
    if len(targets.frames):
        names = file_names([opened.capture.names[frame] for frame in targets.frames])
        truth = opened.loaded(targets.frames, console.bar("images")).images
    folder.mkdir()
    rows = []
    for t, name in enumerate(console.bar("rendering")(names, len(names))):
        image = model.render(targets.views.subset(slice(t, t + 1)))
        cv2.imwrite(str(folder / f"{name}.png"), levels(image[0])[..., ::-1])
        row: dict[str, str | float] = {"view": name}
        if truth is not None:
            scores = score_views(image, np.asarray(truth[t : t + 1]), None, metrics)[0]
            row |= dict(zip(metrics, scores.round(5).tolist(), strict=True))
        rows.append(row)
    return rows


def _table(rows: list[dict], means: dict | None, metrics: Metrics) -> str:
    """Return the metrics, one row a view; or the views' names."""
    if means is None:
        return "".join(f"{row['view']}\n" for row in rows)
    rows = [*rows, {"view": "mean", **means}]
    wide = max(len(row["view"]) for row in rows)
    lines = [f"{row['view']:{wide}}  {columns(row, metrics)}" for row in rows]
    return "\n".join([f"{'view':{wide}}  {heading(metrics)}", *lines, ""])


def render_video(args: argparse.Namespace, console: Console) -> None:
    """Write a flight through a model."""
    if args.video.suffix.lower() != ENDING:
        raise ValueError(f"{args.video}: a video must be a {ENDING} file. Hint: NAME{ENDING}")
    if args.metrics:
        raise ValueError("--metrics scores renderings of frames; allowed only with -o")
    with staged(args.video, [*inputs_of(args), args.model], args.force, folder=False) as stage:
        model = _model(args.model)
        capture = open_capture.opened(args, console).capture
        count, long_side = max(round(args.seconds * RATE), 1), args.long_side or VIDEO_SIDE
        views = flight(capture, args.targets, count, long_side)
        started = time.perf_counter()
        rows = console.bar("rendering")(range(len(views)), len(views))
        rendered = (model.render(views.subset(slice(row, row + 1)))[0] for row in rows)
        write_video(stage, map(levels, rendered), RATE)
        each = (time.perf_counter() - started) / len(views)
    width, height = views.size
    said = f"{len(views)} frames of {width}x{height}, {each:.2f} s each"
    console.say("written", f"{args.video}: {said}")
    video = str(args.video.resolve())
    console.give({"video": video, "frames": len(views), "size": [width, height]})


def file_names(names: Sequence[str]) -> list[str]:
    """Return a file name for each frame, `/` as `_`, all numbered where two would be equal."""
    flat = [name.replace("/", "_") for name in names]
    if len({name.casefold() for name in flat}) == len(flat):
        return flat
    return [f"{name}_{at:04d}" for at, name in enumerate(flat)]


def flight(capture: Capture, request: Request, count: int, long_side: int) -> Views:
    """Return views of an orbit, the smoothed camera path, a camera path's file, or between frames.

    Frames are flown through in the capture's order; a camera path's file gives no more views than
    it has. `long_side` in pixels may be more than the capture's.
    """
    targets = targets_of(capture, request, count)
    views = between(targets.views, count) if len(targets.frames) else targets.views
    scale = long_side / max(views.size)
    width, height = (max(1, round(side * scale)) for side in views.size)
    return Views(views.world_to_camera, views.intrinsics * scale, (width, height))


def between(views: Views, count: int) -> Views:
    """A smooth path through two or more views, at an even speed; one view stands still."""
    if len(views) == 1:
        return views.subset(np.zeros(count, np.int64))
    ways = np.linalg.norm(np.diff(views.centers, axis=0), axis=1)
    ways += STILL * ways.mean() or 1.0
    known = np.concatenate([[0], np.cumsum(ways)])
    times = np.linspace(0, known[-1], count)
    turns = RotationSpline(known, Rotation.from_matrix(views.world_to_camera[:, :, :3]))
    centers = PchipInterpolator(known, views.centers)(times)
    lenses = PchipInterpolator(known, views.intrinsics)(times)
    return Views(poses_at(centers, turns(times).as_matrix()), lenses, views.size)
