"""`fsel compare`: reconstruct from what several methods pick, and compare with held-out frames."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fsel.captures.images.previews import jpeg, sharpness_among
from fsel.captures.lazy import LazyCapture
from fsel.captures.quality.examination import examined
from fsel.captures.quality.findings import BLURRED
from fsel.cli import open_capture
from fsel.cli.console import Console
from fsel.cli.open_capture import inputs_of
from fsel.cli.reconstructor_args import bound, checked
from fsel.cli.scoring import columns, heading, metrics_of
from fsel.core.capture import Capture
from fsel.core.files import json_text
from fsel.core.outputs import staged
from fsel.core.problem import Method, Problem
from fsel.core.subsets import evenly, subset_key
from fsel.core.threads import side_by_side
from fsel.core.wording import counted
from fsel.evaluation.evaluator import Evaluator
from fsel.evaluation.measuring import Run, picks_at, runs
from fsel.evaluation.statistics import Interval
from fsel.pages.compare import Cell, Compared, comparison, differences, verdict
from fsel.selection.focus import Focus, focus_of, outlines
from fsel.selection.problem import measured, request_problem, with_target_depths
from fsel.selection.request import ALL_FRAMES, SelectionRequest, checked_request, method_of, vet
from fsel.selection.select import select_frames, without_bad
from fsel.selection.targets import Targets
from fsel.selectors.pretrained import DEFAULT

PICTURES, FEWEST = 600, 6  # renderings on the page at most, of so many held-out frames at least
QUALITY = 92  # of the page's JPEGs
SIDE_BY_SIDE = ("splats", "gaussians", "radiance_field")  # whose fits leave one another alone
COARSE, FINE = "splats", "gaussians"  # the order of the first need not be that of the second
ORDER = " It may order close selections differently: to decide, use --reconstructor gaussians."
QUICK = {"steps": 500, "gaussians": 5000}  # of FINE, where no reconstructor is named
FIT_SECONDS, FIT_SIDE = 6.6, 192  # of one fit on one core, at so many pixels
MOST_SECONDS = 120.0  # of a core, for all fits by FINE, before COARSE is the default
Picks = dict[Cell, list[np.ndarray]]


def _tried(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """(k,) frames that `fsel select -k` picks of the pool: it does not know the targets."""
    pool = problem.observed
    checked = checked_request(SelectionRequest(problem.capture.subset(pool), k, keep_bad=True))
    # to the end, however slow the machine: the table is the same on each
    checked = replace(checked, patience=replace(checked.patience, ceiling=np.inf))
    return pool[select_frames(checked).selection.indices]


TRIED = Method("tried", "Tried", "observed", nested=False, select=_tried)
# what a person runs
RUN = {TRIED.name: "fsel select", DEFAULT: "fsel select --targets --patience 0"}


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    methods = [TRIED if name == TRIED.name else method_of(name) for name in args.methods]
    settings = judge(args, len(args.k) * len(list(runs(methods))))
    checked(args, **settings)
    metrics = metrics_of(args, console)
    if min(args.k) < 2:
        raise ValueError(f"k is {min(args.k)}; a reconstruction needs at least two frames")
    vet(SelectionRequest(None, max(args.k), args.targets, focus=args.masks or args.box))
    with staged(args.out, inputs_of(args), args.force) as stage:
        opened = open_capture.opened(args, console, args.long_side)
        focus = focus_of(args.box if args.masks is None else args.masks, opened)
        targets = _checked(args, opened, methods, focus)
        held_out, masks = outlines(opened.capture, targets.frames, focus)
        console.say("capture", f"{len(opened.capture)} frames, {opened.layout}; {targets.kind}")
        if masks is not None:
            seen = counted(len(held_out), "held-out frame")
            console.say("object", f"in {seen}, compared only inside it")
        capture = opened.loaded(np.arange(len(opened.capture)), console.bar("images"))
        picks, blurred = _selected(args, console, opened, capture, methods, targets, focus)
        drawn = evenly(len(held_out), max(FEWEST, PICTURES // len(picks)))
        renders: dict[tuple[int, ...], np.ndarray] = {}

        def keep(frames: np.ndarray, rendered: np.ndarray) -> None:
            renders[subset_key(frames)] = np.round(rendered[drawn] * 255).astype(np.uint8)

        truth, views = np.asarray(capture.images[held_out]), capture.view(held_out)
        reconstructor = bound(args, capture, **settings)
        evaluator = Evaluator(reconstructor, held_out, views, truth, masks, metrics, keep)
        scores = _scores(args, evaluator, picks, console)
        shown = {key: renders[subset_key(chosen[0])] for key, chosen in picks.items()}
        how = _how(args, capture, methods)
        compared = _compared(how, evaluator, blurred, drawn, picks, scores, shown)
        content = _content(args, compared, capture, picks)
        table = _table(compared, content["rows"])
        pages = {"html": comparison(compared), "json": json_text(content), "txt": table}
        for ending, text in pages.items():
            (stage / f"compare.{ending}").write_text(text, encoding="utf-8")
    console.text(table)
    console.say("written", f"{args.out}: compare.html, compare.json, compare.txt")
    console.give(content)


def judge(args: argparse.Namespace, fits: int) -> dict[str, int]:
    """Name the reconstructor where the command line does not, and return its settings."""
    if args.reconstructor is not None:
        return {}
    seconds = fits * FIT_SECONDS * (args.long_side / FIT_SIDE) ** 2
    fine = args.steps is not None or seconds <= MOST_SECONDS
    args.reconstructor = FINE if fine else COARSE
    return QUICK if fine else {}


def _how(args: argparse.Namespace, capture: Capture, methods: Sequence[Method]) -> str:
    """Say what renders, and which methods are given the cameras of the held-out frames."""
    width, height = capture.size
    how = f"Reconstructed by {args.reconstructor} and scored at {width}x{height} pixels."
    how += ORDER if args.reconstructor == COARSE else ""
    given = [RUN.get(method.name, method.name) for method in methods if method.aimed]
    others = [RUN.get(m.name, m.name) for m in methods if not m.aimed]
    how += f" The cameras of the held-out frames are known to {', '.join(given) or 'no method'}"
    how += f", not to {', '.join(others)}." if given and others else "."
    return how + (
        f" {RUN[TRIED.name]} made its trials without a limit of time." if TRIED in methods else ""
    )


def _checked(
    args: argparse.Namespace, opened: LazyCapture, methods: Sequence[Method], focus: Focus | None
) -> Targets:
    """Refuse every budget and method that cannot be served, before any image is opened."""
    for method in methods:
        for k in args.k:
            # what takes every frame is compared as such, whatever k is
            named = method_of() if method.name == ALL_FRAMES else method
            request = SelectionRequest(opened, k, args.targets, named, focus=focus)
            targets = checked_request(request).targets
    if not len(targets.frames):
        raise ValueError(
            f"targets are {args.targets!r}: no photos of these views exist; allowed: every:N, or "
            "a .txt list of frame names"
        )
    return targets


def _selected(
    args: argparse.Namespace,
    console: Console,
    opened: LazyCapture,
    capture: Capture,
    methods: Sequence[Method],
    targets: Targets,
    focus: Focus | None,
) -> tuple[Picks, np.ndarray]:
    """Return the picks of every method, and the frames that are blurred."""
    blurred = np.empty(0)
    with console.clock("selecting"):
        if not args.keep_bad:
            health = examined(opened, console.bar("health"))
            targets, health = without_bad(targets, capture, max(args.k), health, console)
            blurred = health.of_kind(BLURRED)
        bar = console.bar("sharpness")
        sharpness_of = sharpness_among(opened.raw.images, opened.longest, bar)
        sharpness, descriptors = measured(methods, capture, sharpness_of)
        problem = request_problem(capture, targets, sharpness, focus, descriptors)
        few = [k for k in args.k if targets.as_many_as(k)]
        more = [k for k in args.k if k not in few]
        picks = _picks(args.seed, with_target_depths(problem), few, methods)
        return picks | _picks(args.seed, problem, more, methods), blurred


def _picks(seed: int, problem: Problem, ks: Sequence[int], methods: Sequence[Method]) -> Picks:
    """Return the picks of each k and method, one a seed; nested methods run once."""

    def rng_of(run: Run, k: int) -> np.random.Generator:
        return np.random.default_rng(seed + run.seed)

    picks: Picks = {}
    for run in runs(methods) if ks else ():
        if run.method.name == ALL_FRAMES:
            picks |= {(k, ALL_FRAMES): [problem.observed] for k in ks}
            continue
        for made in picks_at(problem, run, ks, rng_of):
            picks.setdefault((made.k, run.method.name), []).append(made.frames)
    return picks


def _scores(
    args: argparse.Namespace, evaluator: Evaluator, picks: Picks, console: Console
) -> dict[Cell, np.ndarray]:
    """Return (T, M) metrics of the held-out frames for each k and method, averaged over seeds."""
    scores: dict[Cell, list[np.ndarray]] = {(k, name): [] for k in args.k for name in args.methods}
    runs = [(cell, chosen) for cell in scores for chosen in picks[cell]]
    distinct = list({subset_key(chosen): chosen for _, chosen in runs}.values())
    fits = side_by_side if args.reconstructor in SIDE_BY_SIDE else map
    for _ in console.bar("reconstructing")(fits(evaluator.scores, distinct), len(distinct)):
        pass  # the evaluator knows them from now on
    for cell, chosen in runs:
        scores[cell].append(evaluator.scores(chosen))
    return {cell: np.mean(values, axis=0) for cell, values in scores.items()}


def _compared(
    how: str,
    evaluator: Evaluator,
    blurred: np.ndarray,
    drawn: np.ndarray,
    picks: Picks,
    scores: dict[Cell, np.ndarray],
    shown: dict[Cell, np.ndarray],
) -> Compared:
    """Return the content of the page, with pictures of the held-out frames whose numbers are drawn.

    `shown` are (D, h, w, 3) uint8 renderings of these for each k and method.
    """
    capture = evaluator.reconstructor.capture
    width, height = capture.size
    return Compared(
        source=capture.source,
        how=how,
        names=tuple(capture.names[i] for i in evaluator.frames),
        metrics=tuple(evaluator.metrics),
        scores=scores,
        used={cell: len(picks[cell][0]) for cell in scores},
        shown=tuple(drawn.tolist()),
        truth=[jpeg(image, QUALITY) for image in evaluator.truth[drawn]],
        renders={
            cell: [jpeg(image, QUALITY) for image in images] for cell, images in shown.items()
        },
        blurred=np.isin(evaluator.frames, blurred),
        shape=width / height,
        labels=RUN,
    )


def _content(args: argparse.Namespace, compared: Compared, capture: Capture, picks: Picks) -> dict:
    """Return the content of compare.json, with a row of means for each k and method."""
    rows = []
    for (used, name), (k, *_) in compared.rows.items():
        means = dict(zip(compared.metrics, compared.means((k, name)), strict=True))
        names = [[capture.names[i] for i in frames] for frames in picks[k, name]]
        rows.append({"k": used, "method": name, **means, "seeds": len(names), "picks": names})
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
        "how": compared.how,
    }


def _table(compared: Compared, rows: list[dict]) -> str:
    """Return the metrics as text, a row for each method and k, and how far the first is ahead."""
    first, labels = compared.methods[0], list(map(compared.label, compared.methods))
    wide = max(map(len, labels))
    ahead = "" if len(labels) == 1 else f"  {labels[0]} ahead, dB"
    lines = [f"{'k':>4}  {'method':{wide}}  {heading(compared.metrics)}{ahead}"]
    for row, (cell, budgets) in zip(rows, compared.rows.items(), strict=True):
        label = f"{compared.label(cell[1]):{wide}}"
        line = f"{cell[0]:4d}  {label}  {columns(row, compared.metrics)}"
        cells = [_gap(compared.ahead(k, cell[1])) for k in budgets if cell[1] != first]
        lines.append(f"{line}  {' / '.join(cells)}".rstrip())
    return "\n".join([*lines, compared.how, verdict(compared), ""])


def _gap(gap: Interval) -> str:
    """Return a lead in dB with its 95 % interval, where there is one."""
    interval = "" if np.isnan(gap.low) else f" ({gap.low:+.2f} to {gap.high:+.2f})"
    return f"{gap.mean:+.2f}{interval}"
