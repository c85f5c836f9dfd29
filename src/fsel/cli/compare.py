"""`fsel compare`: reconstruct from what several methods pick, and compare with held-out frames."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence

import cv2
import numpy as np

from fsel import api
from fsel.cli import posing
from fsel.cli.console import Console
from fsel.cli.health import without_bad
from fsel.cli.optimising import bound, checked
from fsel.cli.request import focus_of, inputs_of, outlines
from fsel.cli.scoring import columns, file_names, heading, metrics_of
from fsel.data.capture import Capture
from fsel.data.problem import Method
from fsel.data.subsets import evenly, subset_key
from fsel.evaluation.evaluator import Evaluator
from fsel.evaluation.measuring import Run, picks_at, runs
from fsel.export.compared import Cell, Compared, differences
from fsel.export.versus import comparison
from fsel.health.findings import BLURRED
from fsel.images.previews import sharpness_of_files
from fsel.ingest.lazy import LazyCapture
from fsel.metrics import Metrics
from fsel.outputs.atomic import staged
from fsel.reconstruct import Model, Reconstructor
from fsel.request.focus import Focus
from fsel.request.problem import request_problem
from fsel.request.targets import Targets
from fsel.utils.wording import counted

SHOWN = 6  # held-out frames that are rendered side by side
BAND = 14  # pixels of a caption
QUALITY = 92  # of the page's JPEGs
Picks = dict[Cell, list[np.ndarray]]
Scores = dict[Cell, np.ndarray]


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    checked(args)
    metrics = metrics_of(args, console)
    methods = [api.method_of(name) for name in args.methods]
    with staged(args.out, "compare", inputs_of(args), args.force) as stage:
        opened = posing.opened(args, console, args.long_side)
        focus = focus_of(args, opened)
        targets = _checked(args, opened.capture, methods, focus)
        held_out, masks = outlines(args, opened.capture, targets.frames, focus)
        console.say("capture", f"{len(opened.capture)} frames, {opened.layout}; {targets.kind}")
        if masks is not None:
            shown = counted(len(held_out), "held-out frame")
            console.say("object", f"in {shown}, compared inside of it alone")
        capture = opened.loaded(np.arange(len(opened.capture)), console.bar("images"))
        with console.clock("selecting"):
            targets, health = without_bad(args, console, opened, targets, max(args.k))
            bad = np.empty(0) if health is None else health.of_kind(BLURRED)
            unsharp = np.isin(held_out, bad)
            picks = _picks(args, opened, capture, targets, methods, focus)
        scores, evaluator = _scores(args, capture, (held_out, masks), picks, metrics, console)
        compared = _compared(args, capture, (held_out, unsharp), picks, scores, evaluator)
        (stage / "compare.html").write_text(comparison(compared), encoding="utf-8")
        content = _content(args, compared, _rows(capture, picks, scores, metrics))
        (stage / "compare.json").write_text(json.dumps(content, indent=1), encoding="utf-8")
        table = _table(content, metrics)
        (stage / "compare.txt").write_text(table, encoding="utf-8")
        (stage / "renders").mkdir()
        for name, sheet in _sheets(args, capture, held_out, picks, evaluator):
            cv2.imwrite(str(stage / "renders" / name), sheet[..., ::-1])
    console.text(table)
    console.say("written", f"{args.out}: compare.html, compare.json, compare.txt, renders")
    console.give(content)


def _content(args: argparse.Namespace, compared: Compared, rows: list[dict]) -> dict:
    """Content of compare.json."""
    return {
        "capture": str(args.capture.resolve()),
        "targets": list(compared.names),
        "blurred": [compared.names[i] for i in np.flatnonzero(compared.blurred)],
        "reconstructor": args.reconstructor,
        "long_side": args.long_side,
        "seed": args.seed,
        "rows": rows,
        "differences": differences(compared),
    }


def _checked(
    args: argparse.Namespace, capture: Capture, methods: Sequence[Method], focus: Focus | None
) -> Targets:
    """Refuse every budget and method that cannot be served, before any image is opened."""
    for method in methods:
        for k in args.k:
            if k < 2:
                raise ValueError(f"k is {k}; a reconstruction needs at least two frames")
            # what takes every frame is compared as such, whatever k is
            named = api.method_of() if method.name == api.ALL_FRAMES else method
            targets = api.checked_request(capture, k, args.targets, named, focus)
    if not len(targets.frames):
        raise ValueError(
            f"targets are {args.targets!r}: there is no truth to compare with; allowed: every:N, "
            "or a .txt list of frame names"
        )
    return targets


def _picks(
    args: argparse.Namespace,
    opened: LazyCapture,
    capture: Capture,
    targets: Targets,
    methods: Sequence[Method],
    focus: Focus | None,
) -> Picks:
    """(k, method) -> one selection a seed; nested methods run once, at the largest k."""

    def sharpness_of(frames: np.ndarray) -> np.ndarray:
        return sharpness_of_files([opened.raw.images[i] for i in frames], opened.longest)

    sharpness, descriptors = api.measured(methods, capture, sharpness_of)
    problem = request_problem(capture, targets, sharpness, focus, descriptors)

    def chance(run: Run, k: int) -> np.random.Generator:
        return np.random.default_rng(args.seed + run.seed)

    picks: Picks = {}
    for run in runs(methods):
        if run.method.name == api.ALL_FRAMES:
            picks |= {(k, api.ALL_FRAMES): [problem.observed] for k in args.k}
            continue
        for made in picks_at(problem, run, args.k, chance):
            picks.setdefault((made.k, run.method.name), []).append(made.frames)
    return picks


def _scores(
    args: argparse.Namespace,
    capture: Capture,
    held_out: tuple[np.ndarray, np.ndarray | None],
    picks: Picks,
    metrics: Metrics,
    console: Console,
) -> tuple[Scores, Evaluator]:
    """(k, method) -> (seeds, T, M) metrics of the held-out frames, in their masks."""
    frames, masks = held_out
    truth = np.asarray(capture.images[frames])
    keeping = _Keeping(bound(args, capture))
    evaluator = Evaluator(keeping, frames, capture.view(frames), truth, masks, metrics)
    order = [(k, name) for k in args.k for name in args.methods]
    runs = [(key, chosen) for key in order for chosen in picks[key]]
    scores: dict[Cell, list[np.ndarray]] = {key: [] for key in order}
    for key, chosen in console.bar("reconstructing")(runs, len(runs)):
        evaluator(chosen)  # what does not finish is refused
        scores[key].append(evaluator.measure(chosen).scores)
    return {key: np.array(values) for key, values in scores.items()}, evaluator


def _rows(capture: Capture, picks: Picks, scores: Scores, metrics: Metrics) -> list[dict]:
    """A row of mean metrics for each number of frames and method, over frames and seeds."""
    rows: dict[Cell, dict] = {}
    for (k, name), values in scores.items():
        used = len(picks[k, name][0])
        means = dict(zip(metrics, values.mean(axis=(0, 1)).round(5).tolist(), strict=True))
        names = [[capture.names[i] for i in chosen] for chosen in picks[k, name]]
        kept = {"k": used, "method": name, **means, "seeds": len(values), "picks": names}
        rows.setdefault((used, name), kept)
    return list(rows.values())


def _compared(
    args: argparse.Namespace,
    capture: Capture,
    frames: tuple[np.ndarray, np.ndarray],
    picks: Picks,
    scores: Scores,
    evaluator: Evaluator,
) -> Compared:
    """The same with pictures, at the size that was compared.

    Args:
        args: the parsed command line.
        capture: the capture.
        frames: (T,) held-out frames, and (T,) bool which are blurred.
        picks: of each k and method.
        scores: theirs.
        evaluator: which keeps the models.
    """
    held_out, unsharp = frames
    drawn = _drawn(held_out)
    views = capture.view(held_out[drawn])
    renders = {}
    for key in scores:
        images = evaluator.reconstructor.fit(np.sort(picks[key][0])).render(views)
        renders[key] = [_jpeg(np.round(image * 255).astype(np.uint8)) for image in images]
    width, height = capture.size
    return Compared(
        source=capture.source,
        how=f"Reconstructed and compared by {args.reconstructor} at {width}x{height} pixels, "
        "shown larger. Hint: --reconstructor gaussians and a larger --long-side are for looks.",
        names=tuple(capture.names[i] for i in held_out),
        metrics=tuple(evaluator.metrics),
        scores={key: values.mean(axis=0) for key, values in scores.items()},
        used={key: len(picks[key][0]) for key in scores},
        shown=tuple(drawn.tolist()),
        truth=[_jpeg(np.asarray(capture.images[frame])) for frame in held_out[drawn]],
        renders=renders,
        blurred=unsharp,
    )


def _drawn(held_out: np.ndarray) -> np.ndarray:
    """Numbers of the held-out frames that are shown."""
    return evenly(len(held_out), SHOWN)


def _jpeg(image: np.ndarray) -> bytes:
    bgr = np.ascontiguousarray(image[..., ::-1])
    return cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()


class _Keeping:
    """A reconstructor that fits no subset twice: the sheets show the models that were scored."""

    def __init__(self, reconstructor: Reconstructor) -> None:
        self.reconstructor, self.capture = reconstructor, reconstructor.capture
        self.models: dict[tuple[int, ...], Model] = {}

    def fit(self, frames: np.ndarray) -> Model:
        key = subset_key(frames)
        if key not in self.models:
            self.models[key] = self.reconstructor.fit(frames)
        return self.models[key]


def _table(content: dict, metrics: Metrics) -> str:
    """The metrics, one row a method and k, and what the differences say."""
    rows = content["rows"]
    wide = max(len(row["method"]) for row in rows)
    lines = [f"{'k':>4}  {'method':{wide}}  {heading(metrics)}"]
    for row in rows:
        lines.append(f"{row['k']:4d}  {row['method']:{wide}}  {columns(row, metrics)}")
    return "\n".join([*lines, *(gap["verdict"] for gap in content["differences"]), ""])


def _sheets(
    args: argparse.Namespace,
    capture: Capture,
    held_out: np.ndarray,
    picks: Picks,
    evaluator: Evaluator,
) -> Iterator[tuple[str, np.ndarray]]:
    """(file name, image) of a few held-out frames; a row for each k: truth, then methods."""
    frames = held_out[_drawn(held_out)]
    views = capture.view(frames)
    rows: list[list[np.ndarray]] = [[] for _ in frames]
    for k in args.k:
        rendered = [
            evaluator.reconstructor.fit(np.sort(picks[k, name][0])).render(views)
            for name in args.methods
        ]
        for at, frame in enumerate(frames):
            cells = [_captioned(np.asarray(capture.images[frame]), "truth")]
            for name, images in zip(args.methods, rendered, strict=True):
                cells.append(_captioned(np.round(images[at] * 255).astype(np.uint8), f"{name} {k}"))
            rows[at].append(np.concatenate(cells, axis=1))
    names = file_names([capture.names[frame] for frame in frames])
    for name, sheet in zip(names, rows, strict=True):
        yield f"{name}.png", np.concatenate(sheet)


def _captioned(image: np.ndarray, text: str) -> np.ndarray:
    band = np.full((BAND, *image.shape[1:]), 255, np.uint8)
    cv2.putText(band, text, (2, BAND - 4), cv2.FONT_HERSHEY_SIMPLEX, 0.35, (0, 0, 0), 1)
    return np.concatenate([band, image])
