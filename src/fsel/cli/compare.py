"""`fsel compare`: reconstruct from what several methods pick, and compare with held-out frames."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from typing import Any

import cv2
import numpy as np

from fsel.captures.images.previews import jpeg, sharpness_among
from fsel.captures.images.video import captioned
from fsel.captures.lazy import LazyCapture
from fsel.captures.quality.findings import BLURRED
from fsel.cli import open_capture
from fsel.cli.console import Console
from fsel.cli.open_capture import inputs_of
from fsel.cli.optimising import bound, checked
from fsel.cli.scoring import columns, file_names, heading, metrics_of
from fsel.core.capture import Capture, Views
from fsel.core.outputs import staged
from fsel.core.problem import Method, Problem
from fsel.core.subsets import evenly, subset_key
from fsel.core.wording import counted
from fsel.evaluation.evaluator import Evaluator
from fsel.evaluation.measuring import Run, picks_at, runs
from fsel.metrics import Metrics
from fsel.pages.compare import Cell, Compared, comparison, differences, verdict
from fsel.reconstruct import Model, Reconstructor
from fsel.selection.cover import served
from fsel.selection.focus import Focus, focus_of, outlines
from fsel.selection.problem import measured, request_problem
from fsel.selection.request import ALL_FRAMES, SelectionRequest, checked_request, method_of
from fsel.selection.select import examined_targets
from fsel.selection.targets import Targets

SHEETS = 6  # held-out frames that have a picture of their own in renders
PICTURES = 600  # renderings on the page at most, or six frames
QUALITY = 92  # of the page's JPEGs
SEEN = 3  # picks that serve a sparse point
SERVED = ("served", "served_by_every_nth")  # keys of compare.json
HEADING = "  served   n-th"
NOTE = (
    f"served: of the sparse points that {SEEN} frames or more see, those that {SEEN} picks or more "
    "see; n-th: as many frames evenly spaced."
)
STARRED = "*: beyond chance, by the paired 95 % interval over held-out frames."
COARSE = "splats"  # whose order others need not confirm
ORDER = (
    " On ten captures it and trained Gaussians agreed in 32 of 48 cases on which of two selections "
    "is better. Hint: --reconstructor gaussians asks them."
)
Picks = dict[Cell, list[np.ndarray]]
Scores = dict[Cell, np.ndarray]


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    checked(args)
    metrics = metrics_of(args, console)
    methods = [method_of(name) for name in args.methods]
    with staged(args.out, inputs_of(args), args.force) as stage:
        opened = open_capture.opened(args, console, args.long_side)
        focus = focus_of(args.box if args.masks is None else args.masks, opened)
        targets = _checked(args, opened, methods, focus)
        held_out, masks = outlines(opened.capture, targets.frames, focus)
        console.say("capture", f"{len(opened.capture)} frames, {opened.layout}; {targets.kind}")
        if masks is not None:
            shown = counted(len(held_out), "held-out frame")
            console.say("object", f"in {shown}, compared inside of it alone")
        capture = opened.loaded(np.arange(len(opened.capture)), console.bar("images"))
        with console.clock("selecting"):
            bad = np.empty(0)
            if not args.keep_bad:
                targets, health = examined_targets(
                    opened, targets, max(args.k), console, matching=args.check_poses
                )
                bad = health.of_kind(BLURRED)
            unsharp = np.isin(held_out, bad)
            bar = console.bar("sharpness")
            sharpness_of = sharpness_among(opened.raw.images, opened.longest, bar)
            sharpness, descriptors = measured(methods, capture, sharpness_of)
            problem = request_problem(capture, targets, sharpness, focus, descriptors)
            picks = _picks(args, problem, methods)
        drawn = evenly(len(held_out), max(SHEETS, PICTURES // len(picks)))
        keeping = _Keeping(bound(args, capture), drawn)
        scores = _scores(args, keeping, (held_out, masks), picks, metrics, console)
        compared = _compared(args, keeping, (held_out, unsharp), picks, scores, metrics)
        (stage / "compare.html").write_text(comparison(compared), encoding="utf-8")
        rows = _rows(capture, compared, picks, served(problem, picks, SEEN))
        content = _content(args, compared, rows)
        (stage / "compare.json").write_text(json.dumps(content, indent=1), encoding="utf-8")
        table = _table(compared, rows)
        (stage / "compare.txt").write_text(table, encoding="utf-8")
        (stage / "renders").mkdir()
        for name, sheet in _sheets(args, keeping, held_out[drawn], picks):
            cv2.imwrite(str(stage / "renders" / name), sheet[..., ::-1])
    console.text(table)
    console.say("written", f"{args.out}: compare.html, compare.json, compare.txt, renders")
    console.give(content)


def _content(args: argparse.Namespace, compared: Compared, rows: list[dict]) -> dict:
    """Return the content of compare.json."""
    return {
        "capture": str(args.capture.resolve()),
        "targets": list(compared.names),
        "blurred": [compared.names[i] for i in np.flatnonzero(compared.blurred)],
        "reconstructor": args.reconstructor,
        "long_side": args.long_side,
        "seed": args.seed,
        "rows": rows,
        "differences": differences(compared),
        "verdict": verdict(compared),
    }


def _checked(
    args: argparse.Namespace, opened: LazyCapture, methods: Sequence[Method], focus: Focus | None
) -> Targets:
    """Refuse every budget and method that cannot be served, before any image is opened."""
    for method in methods:
        for k in args.k:
            if k < 2:
                raise ValueError(f"k is {k}; a reconstruction needs at least two frames")
            # what takes every frame is compared as such, whatever k is
            named = method_of() if method.name == ALL_FRAMES else method
            request = SelectionRequest(opened, k, args.targets, named, focus=focus)
            targets = checked_request(request).targets
    if not len(targets.frames):
        raise ValueError(
            f"targets are {args.targets!r}: there is no truth to compare with; allowed: every:N, "
            "or a .txt list of frame names"
        )
    return targets


def _picks(args: argparse.Namespace, problem: Problem, methods: Sequence[Method]) -> Picks:
    """Return the picks of each k and method, one a seed; nested methods run once."""

    def rng_of(run: Run, k: int) -> np.random.Generator:
        return np.random.default_rng(args.seed + run.seed)

    picks: Picks = {}
    for run in runs(methods):
        if run.method.name == ALL_FRAMES:
            picks |= {(k, ALL_FRAMES): [problem.observed] for k in args.k}
            continue
        for made in picks_at(problem, run, args.k, rng_of):
            picks.setdefault((made.k, run.method.name), []).append(made.frames)
    return picks


def _scores(
    args: argparse.Namespace,
    keeping: _Keeping,
    held_out: tuple[np.ndarray, np.ndarray | None],
    picks: Picks,
    metrics: Metrics,
    console: Console,
) -> Scores:
    """Return (seeds, T, M) metrics of the held-out frames for each k and method, in their masks."""
    (frames, masks), capture = held_out, keeping.capture
    truth = np.asarray(capture.images[frames])
    evaluator = Evaluator(keeping, frames, capture.view(frames), truth, masks, metrics)
    order = [(k, name) for k in args.k for name in args.methods]
    runs = [(key, chosen) for key in order for chosen in picks[key]]
    scores: dict[Cell, list[np.ndarray]] = {key: [] for key in order}
    for key, chosen in console.bar("reconstructing")(runs, len(runs)):
        evaluator(chosen)  # what does not finish is refused
        scores[key].append(evaluator.measure(chosen).scores)
    return {key: np.array(values) for key, values in scores.items()}


def _rows(
    capture: Capture, compared: Compared, picks: Picks, served: dict[Cell, tuple[float, float]]
) -> list[dict]:
    """Return a row of mean metrics for each number of frames and method."""
    rows = []
    for (used, name), (k, *_) in compared.rows.items():
        chosen = picks[k, name]
        means = dict(zip(compared.metrics, compared.means((k, name)), strict=True))
        means |= dict(zip(SERVED, served.get((k, name), ()), strict=False))
        names = [[capture.names[i] for i in frames] for frames in chosen]
        rows.append({"k": used, "method": name, **means, "seeds": len(chosen), "picks": names})
    return rows


def _compared(
    args: argparse.Namespace,
    keeping: _Keeping,
    frames: tuple[np.ndarray, np.ndarray],
    picks: Picks,
    scores: Scores,
    metrics: Metrics,
) -> Compared:
    """Return the content of the page."""
    capture, drawn, renders = keeping.capture, keeping.drawn, keeping.renders(picks)
    held_out, unsharp = frames
    width, height = capture.size
    return Compared(
        source=capture.source,
        how=f"Reconstructed and compared by {args.reconstructor} at {width}x{height} pixels."
        + (ORDER if args.reconstructor == COARSE else ""),
        names=tuple(capture.names[i] for i in held_out),
        metrics=tuple(metrics),
        scores={key: values.mean(axis=0) for key, values in scores.items()},
        used={key: len(picks[key][0]) for key in scores},
        shown=tuple(drawn.tolist()),
        truth=[jpeg(np.asarray(capture.images[frame]), QUALITY) for frame in held_out[drawn]],
        renders={
            key: [jpeg(image, QUALITY) for image in images] for key, images in renders.items()
        },
        blurred=unsharp,
        shape=width / height,
    )


class _Keeping:
    """A reconstructor whose models keep what they render of some views: the page shows what was
    scored.

    Attributes:
        images: frames -> (D, h, w, 3) uint8 renderings of the drawn views.
    """

    def __init__(self, reconstructor: Reconstructor, drawn: np.ndarray) -> None:
        self.reconstructor, self.capture = reconstructor, reconstructor.capture
        self.drawn = drawn
        self.images: dict[tuple[int, ...], np.ndarray] = {}

    def renders(self, picks: Picks) -> dict[Cell, np.ndarray]:
        """Return the renderings of each k and method, by the picks of its first seed."""
        return {key: self.images[subset_key(chosen[0])] for key, chosen in picks.items()}

    def fit(self, frames: np.ndarray) -> Any:  # a Model, by way of `_Kept.__getattr__`
        return _Kept(self.reconstructor.fit(frames), self, subset_key(frames))


class _Kept:
    """A model that keeps what it renders."""

    def __init__(self, model: Model, keeping: _Keeping, key: tuple[int, ...]) -> None:
        self.model, self.keeping, self.key = model, keeping, key

    def render(self, views: Views) -> np.ndarray:
        images = self.model.render(views)
        drawn = images[self.keeping.drawn]
        self.keeping.images[self.key] = np.round(drawn * 255).astype(np.uint8)
        return images

    def __getattr__(self, name: str) -> Any:
        return getattr(self.model, name)


def _table(compared: Compared, rows: list[dict]) -> str:
    """Return the metrics as text, a row for each method and k, and how far the first is ahead."""
    first, wide = compared.methods[0], max(map(len, compared.methods))
    known = SERVED[0] in rows[0]
    ahead = "" if len(compared.methods) == 1 else f"  {first} ahead, dB"
    head = f"{'k':>4}  {'method':{wide}}  {heading(compared.metrics)}"
    lines = [f"{head}{HEADING if known else ''}{ahead}"]
    for row, (cell, budgets) in zip(rows, compared.rows.items(), strict=True):
        shares = "".join(f"  {row[name]:6.1%}" for name in SERVED if known)
        line = f"{cell[0]:4d}  {cell[1]:{wide}}  {columns(row, compared.metrics)}{shares}"
        gaps = [compared.ahead(k, cell[1]) for k in budgets if cell[1] != first]
        cells = [f"{gap.mean:+.2f}{'*' if gap.excludes_zero else ''}" for gap in gaps]
        lines.append(f"{line}  {' / '.join(cells)}".rstrip())
    notes = [NOTE] if known else []
    starred = [STARRED] if any("*" in line for line in lines) else []
    return "\n".join([*lines, *notes, *starred, compared.how, verdict(compared), ""])


def _sheets(
    args: argparse.Namespace, keeping: _Keeping, shown: np.ndarray, picks: Picks
) -> Iterator[tuple[str, np.ndarray]]:
    """Yield file name and image of a few held-out frames: a row for each k, truth, then methods."""
    capture, renders, few = keeping.capture, keeping.renders(picks), evenly(len(shown), SHEETS)
    names = file_names([capture.names[frame] for frame in shown[few]])
    for name, at in zip(names, few, strict=True):
        truth = captioned(np.asarray(capture.images[shown[at]]), "truth")
        rows = []
        for k in args.k:
            cells = [captioned(renders[k, by][at], f"{by} {k}") for by in args.methods]
            rows.append(np.concatenate([truth, *cells], axis=1))
        yield f"{name}.png", np.concatenate(rows)
