"""`fsel select`: pick frames and write them as lists and as a capture for trainers."""

from __future__ import annotations

import argparse
import shlex
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np

from fsel.captures.images.previews import check_pixels, picture_side, thumbnails
from fsel.captures.lazy import LazyCapture
from fsel.captures.poses.placement import notes
from fsel.captures.quality import findings
from fsel.cli import unposed
from fsel.cli.console import Console
from fsel.cli.open_capture import inputs_of, opened, reasons
from fsel.cli.options import OPENING, UNPOSED
from fsel.cli.reconstructor_args import stopped_by_interrupt
from fsel.cli.select_options import RECORDED
from fsel.core.files import json_text
from fsel.core.outputs import staged
from fsel.core.wording import counted
from fsel.pages.report import REPORT, page
from fsel.pages.shown import Commands, ReportContent, frames_shown
from fsel.selection.budget import Auto
from fsel.selection.export import record, subset
from fsel.selection.export.subset import FRAMES
from fsel.selection.outcome import Outcome
from fsel.selection.request import AUTO, CheckedRequest, SelectionRequest, checked_request, vet
from fsel.selection.select import select_frames
from fsel.selection.targets import ALL
from fsel.selection.validation import TimeBudget

TRIED = "interrupted: keeping the best selection so far; press Ctrl-C again to quit"
AGAINST = (
    *("-k", "--always", "--never", "--method", "--loss", "--vram", "--trainer", "--patience"),
    *("-o", "--out"),
)
"""Options that the command of a page, which changes single picks, leaves out or states itself."""


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    if args.poses == UNPOSED:
        unposed.run(args, console)
        return
    started = time.perf_counter()
    if (args.vram is None) != (args.trainer is None) or (args.vram and args.k != AUTO):
        raise ValueError(
            "--vram and --trainer need each other and -k auto. Hint: --vram 8GB --trainer gsplat"
        )
    if args.loss is not None and args.k != AUTO:
        raise ValueError(f"--loss {args.loss:g} needs -k auto")
    wanted = _request(args)
    vet(wanted)  # before poses are sought
    with staged(args.out, inputs_of(args), args.force) as stage:
        source = opened(args, console)
        form = _form(args, source)
        subset.check_cameras(source.raw, form.undistort)
        number = _auto(args, source, form) if args.k == AUTO else args.k
        wanted = replace(wanted, source=source, k=number)
        content = _selected(args, console, stage, wanted, form, started)
    _say_end(args, console, content, time.perf_counter() - started)
    console.give(content)


def _selected(
    args: argparse.Namespace,
    console: Console,
    stage: Path,
    request: SelectionRequest,
    form: subset.Form,
    started: float,
) -> dict:
    """Select as a request says, and write it to a stage; return the record's content."""
    source = request.opened
    assert source is not None
    seconds = {"read": time.perf_counter() - started}
    checked = checked_request(request)
    _say_request(console, checked, source)
    with _trying(checked.patience, console) as patience:
        outcome = select_frames(replace(checked, patience=patience), console)
    written = time.perf_counter()
    outcome = _write(stage, source, outcome, form, console)
    content = record.content(outcome, source, form, _stated(args))
    shown = _shown(args, source, outcome, content)
    (stage / REPORT).write_text(page(shown), encoding="utf-8")
    seconds |= outcome.seconds | {"write": time.perf_counter() - written}
    seconds["total"] = time.perf_counter() - started
    content["seconds"] = {name: round(value, 4) for name, value in seconds.items()}
    (stage / record.RECORD).write_text(json_text(content), encoding="utf-8")
    _say_outcome(console, outcome)
    return content


def _auto(args: argparse.Namespace, source: LazyCapture, form: subset.Form) -> Auto:
    """Return how the number of frames is found, for images of the size that is written."""
    camera = source.raw.cameras[0]
    scale = (form.long_side or source.longest) / source.longest
    size = (max(1, round(camera.width * scale)), max(1, round(camera.height * scale)))
    stated = {"loss": args.loss, "memory": args.vram, "trainer": args.trainer}
    return Auto(size=size, **{name: value for name, value in stated.items() if value is not None})


def _request(args: argparse.Namespace) -> SelectionRequest:
    """Return what the command line asks for, of a capture yet to be opened."""
    return SelectionRequest(
        source=None,
        k=args.k,
        targets=args.targets,
        method=args.method,
        weights=args.weights,
        patience=args.patience,
        focus=args.box if args.masks is None else args.masks,
        always=args.always,
        never=args.never,
        keep_bad=args.keep_bad,
        images=not args.geometry_only,
        views=args.views,
    )


def _form(args: argparse.Namespace, source: LazyCapture) -> subset.Form:
    """Return the form in which the subset is written."""
    side = args.long_side
    return subset.Form(
        args.link,
        None if side is None or side >= source.longest else side,
        matched=not args.geometry_only,
        shapes=args.masks,
        undistort=args.undistort,
    )


def _stated(args: argparse.Namespace) -> dict[str, dict]:
    """Return what selection.json repeats of the command line."""
    given = {name: getattr(args, name) for name in RECORDED}
    if args.weights:
        given["weights"] = args.weights.resolve()
    capture = {
        "folder": str(Path(args.capture).resolve()),
        "beside": [str(path.resolve()) for path in args.beside],
        "opened": {name: getattr(args, name) for name in OPENING},
    }
    settings = {k: str(value) if isinstance(value, Path) else value for k, value in given.items()}
    return {"capture": capture, "settings": settings}


def _write(
    stage: Path, source: LazyCapture, outcome: Outcome, form: subset.Form, console: Console
) -> Outcome:
    """Write all but the pages; return the outcome with the points that the picks see."""
    picks, held_out = outcome.selection.indices, outcome.targets.frames
    # every frame that is written is decoded, so that none without pixels is written
    used = np.union1d(picks, held_out)
    check_pixels([source.raw.images[i] for i in [*picks, *held_out]])
    with console.clock("writing"):
        points = subset.write(stage, source, picks, held_out, form)
    if outcome.health is not None:
        findings.write(outcome.health, source.capture.names, stage / findings.TABLE)
    return replace(outcome, seen=points.seen_from(np.searchsorted(used, picks), len(used)))


def _shown(
    args: argparse.Namespace, source: LazyCapture, outcome: Outcome, content: dict
) -> ReportContent:
    """Return what the report shows; pictures where images are looked at."""
    pictures = outcome.health.pictures if outcome.health else {}
    if not (pictures or args.geometry_only):
        frames = frames_shown(outcome).tolist()
        side = picture_side(len(frames))
        made = thumbnails([source.raw.images[i] for i in frames], source.longest, side)
        pictures = {frame: jpeg for frame, jpeg in zip(frames, made, strict=True) if jpeg}
    return ReportContent(
        outcome=outcome,
        picked=content["frames"],
        left=content["left"],
        pictures=pictures,
        commands=commands(args),
        notes=notes(source.found),
        times={shot["name"]: shot["seconds"] for shot in (source.found or {}).get("video", ())},
    )


def _say_request(console: Console, checked: CheckedRequest, source: LazyCapture) -> None:
    """Say what is selected from, and for which views."""
    camera, targets = source.raw.cameras[0], checked.targets
    frames = counted(len(source.capture), "frame")
    console.say("capture", f"{frames} of {camera.width}x{camera.height}, {source.layout}")
    if gone := source.left_out:
        console.warn(f"{counted(len(gone), 'frame')} left out: {reasons(gone)}")
    what = f"{targets.kind}, {counted(len(targets.views), 'view')}"
    if targets.kind == ALL:
        beside = "" if checked.focus else " and as many off the path"
        what += f"{beside} (--targets changes this)"
    console.say("targets", what)
    if checked.focus is not None:
        blind = counted(len(targets.blind), "frame") + " without a view of it never picked"
        changed = f"only views that see it count, {blind}, nothing tried"
        console.say("object", f"from {checked.focus.kind} for {frames}: {changed}")
    if far := targets.far.sum():
        console.warn(f"{far} of {len(targets.views)} target views are far from every camera")


def _say_outcome(console: Console, outcome: Outcome) -> None:
    """Print what was picked and why, how many frames, and how close they are to the views."""
    selection = outcome.selection
    console.say("result", record.summary(outcome))
    if selection.budget is not None:
        console.text(f"{selection.budget.table}\n")
        console.say("k", record.reason(selection.budget))
        if (most := selection.budget.within) is not None:
            limit = "more than" if most > selection.budget.frames else "not more than"
            fits = f"{counted(most, 'frame')} of {selection.budget.rule.trainer} fit"
            console.say("memory", f"{fits}, {limit} the {selection.budget.frames} picked")
    console.say("picked", f"{counted(len(selection), 'frame')}. {record.closeness(outcome)}")


def _say_end(args: argparse.Namespace, console: Console, content: dict, seconds: float) -> None:
    """Print what was cut, where the result is, and what comes next."""
    tried = content["tried"]
    if tried and tried["cut"]:
        fits = counted(tried["fits"], "fit")
        console.say("stopped", f"trying, after {fits}: more may keep other picks")
    if not content["targets"]["held_out"]:
        hint = "" if args.targets else " (--targets every:8 holds frames out)"
        console.say("held out", f"none: nerfstudio evaluates on the picks themselves{hint}")
    console.say("written", f"{args.out} after {seconds:.2f} s")
    console.say("open", shlex.quote(str(args.out / REPORT)))
    console.say("next", shlex.join(["fsel", "reconstruct", str(args.out), "-o", f"{args.out}.ply"]))


@contextmanager
def _trying(patience: TimeBudget, console: Console) -> Iterator[TimeBudget]:
    """Show the progress of trying selections; Ctrl-C keeps what is best."""
    if not patience.seconds:
        yield patience
        return
    with console.steps("trying", "fit") as show, stopped_by_interrupt(console, TRIED) as stop:

        def progress(made: int, planned: int, gone: float) -> bool:
            show(made, planned)
            return not stop()

        yield replace(patience, progress=progress)


def commands(args: argparse.Namespace) -> Commands:
    """Return the command lines that the report of a selection offers."""
    place = args.out
    editing = ["fsel", *without(args.words, AGAINST), "-o", f"{place}_edit"]
    view = ["fsel", "view", str(place), "-o", f"{place}.html"]
    return Commands(shlex.join(editing), str(place / FRAMES), shlex.join(view))


def without(words: Sequence[str], options: Sequence[str]) -> list[str]:
    """Return a command line without --force and some options with values; also abbreviated ones."""
    known = argparse.ArgumentParser(add_help=False)
    known.add_argument("--force", action="store_true")
    for name in options:
        known.add_argument(name)
    return known.parse_known_args(list(words))[1]
