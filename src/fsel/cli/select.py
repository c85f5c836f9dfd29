"""`fsel select`: pick frames and write them as lists and as a capture for trainers."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np

from fsel.captures.images.previews import check_pixels, sharpness_of_files, thumbnails
from fsel.captures.lazy import LONG_SIDE, LazyCapture
from fsel.cli import health as frame_health
from fsel.cli import posing
from fsel.cli.console import Console
from fsel.cli.request import focus_of, inputs_of, reasons
from fsel.cli.rerun_command import commands
from fsel.cli.select_content import selection_content
from fsel.cli.select_limits import (
    budget_of,
    check_budget,
    form_of,
    patience_of,
)
from fsel.cli.trying import trying
from fsel.core.capture import Capture
from fsel.core.outputs import staged
from fsel.core.problem import Method
from fsel.core.wording import counted
from fsel.features.appearance import DINOV2_SIDE, LAB_HOG, descriptors
from fsel.features.appearance import check as check_appearance
from fsel.pages.report import REPORT, page
from fsel.pages.shown import ReportContent, frames_shown, picture_side
from fsel.selection import api
from fsel.selection.budget import Auto
from fsel.selection.export import record, subset
from fsel.selection.focus import Focus
from fsel.selection.scene_depth import behind
from fsel.selection.targets import ALL, ORBIT, Targets

SIDES = {LAB_HOG: LONG_SIDE, "dinov2": DINOV2_SIDE}  # of images that are described


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    started = time.perf_counter()
    check_budget(args)
    method = api.method_of(args.method, args.weights)
    _check_appearance(args, method)
    with staged(args.out, inputs_of(args), args.force) as stage:
        opened = posing.opened(args, console, SIDES[args.appearance])
        seconds = {"read": time.perf_counter() - started}
        outcome = _select(args, console, opened, method, seconds)
        written = time.perf_counter()
        picks, health = outcome.selection.indices, outcome.health
        held_out = outcome.targets.frames
        pictures = _pictures(args, opened, outcome)
        form = form_of(args, opened)
        with console.clock("writing"):
            points = subset.write(stage, opened, picks, held_out, form)
        used = np.union1d(picks, held_out)
        seen = points.seen_from(np.searchsorted(used, picks), len(used))
        outcome = replace(outcome, seen=seen)
        entries = record.picked(outcome)
        left = record.left(outcome) + record.unplaced(opened.found)
        wishes = commands(args, len(picks))
        shown = ReportContent(outcome, entries, left, pictures, wishes, posing.notes(opened.found))
        (stage / REPORT).write_text(page(shown), encoding="utf-8")
        if args.sheet:
            from fsel.pages.sheet import sheet  # here: few ask for it, and it draws with Pillow

            cv2.imwrite(str(stage / "sheet.png"), sheet(shown)[..., ::-1])
        names = "".join(f"{name}\n" for name in outcome.selection.names)
        (stage / "frames.txt").write_text(names, encoding="utf-8")
        if health is not None:
            frame_health.write(health, opened.capture.names, stage / frame_health.BAD)
        seconds["write"] = time.perf_counter() - written
        seconds["total"] = time.perf_counter() - started
        content = selection_content(args, opened, outcome, method, seconds) | {
            "turn": None if form.turn is None else form.turn.tolist(),
            "frames": entries,
            "left": left,
            "bad": None if health is None else record.bad_frames(health, opened.capture.names),
        }
        text = json.dumps(content, indent=1, ensure_ascii=False)
        (stage / record.RECORD).write_text(text, encoding="utf-8")
    _say_outcome(console, outcome, method)
    console.say("written", f"{args.out} after {seconds['total']:.2f} s")
    console.give(content)


def _say_outcome(console: Console, outcome: record.Outcome, method: Method) -> None:
    """Say why so many frames, what was changed after they were picked, and how well they serve."""
    reached = outcome.service.curve[-1]
    if outcome.selection.budget is not None:
        console.say("k", record.reason(outcome.selection.budget))
    tried = outcome.selection.tried
    if tried is not None:
        console.say("tried", record.trials(tried))
    if outcome.selection.cover is not None:
        console.say("cover", record.covered(outcome.selection.cover))
    picked = len(outcome.selection.names)
    name = method.name if tried is None else tried.kept
    console.say("picked", f"{counted(picked, 'frame')} by {name}, service {reached:.1%}")


def _checked(
    args: argparse.Namespace, console: Console, opened: LazyCapture, method: Method
) -> tuple[int | Auto | None, Focus | None, Targets]:
    """Number of frames, object and targets of the command line.

    What cannot be done is refused here, before any image is opened.
    """
    capture = opened.capture
    width, height = opened.raw.cameras[0].width, opened.raw.cameras[0].height
    console.say("capture", f"{len(capture)} frames of {width}x{height}, {opened.layout}")
    if gone := opened.left_out:
        console.warn(f"{counted(len(gone), 'frame')} left out: {reasons(gone)}")
    subset.check_cameras(opened.raw, args.undistort)
    focus = focus_of(args, opened)
    k = budget_of(args, opened)
    targets = api.checked_request(capture, k, args.targets, method, focus, args.always, args.never)
    api.check_cover(args.cover, args.cover_share, k, targets, method)
    what = f"{targets.kind}, by {counted(len(targets.views), 'view')}"
    if targets.kind == ALL:
        what += "" if focus else " and as many beside them"
        what += " (--targets says otherwise)"
    console.say("targets", what)
    if targets.far.any():
        console.warn(
            f"{targets.far.sum()} of {len(targets.views)} target views lie far from every camera"
        )
    _warn_of_walls(args, console, opened, targets)
    return k, focus, targets


def _select(
    args: argparse.Namespace,
    console: Console,
    opened: LazyCapture,
    method: Method,
    seconds: dict[str, float],
) -> record.Outcome:
    """Select as the command line asks."""
    k, focus, targets = _checked(args, console, opened, method)
    patience = patience_of(args, k, targets, method, focus)
    began, images = time.perf_counter(), not args.geometry_only
    targets, health = frame_health.without_bad(args, console, opened, targets, k, images=images)
    sharpness = np.zeros(len(opened.capture))
    if images and "sharpness" in method.reads:
        files, bar = opened.raw.images, console.bar("sharpness")
        sharpness = sharpness_of_files(files, opened.longest, bar)
    seconds["health"] = time.perf_counter() - began
    capture = api.as_read(
        opened,
        method,
        args.k,
        patience,
        args.cover,
        bar=console.bar("images"),
        clock=console.clock("points"),
    )
    with trying(patience, console) as trials:
        selection = api.select(
            capture,
            k,
            targets,
            method,
            args.seed,
            patience=trials,
            cover=args.cover,
            cover_share=args.cover_share,
            sharpness=sharpness,
            focus=focus,
            descriptors=_describing(args, seconds),
        )
    seconds["select"] = selection.seconds
    return record.Outcome(capture, targets, selection, method, health, focus)


def _warn_of_walls(
    args: argparse.Namespace, console: Console, opened: LazyCapture, targets: Targets
) -> None:
    """Say how many views of an orbit lie behind what the cameras saw."""
    if args.targets != ORBIT:
        return
    capture = opened.with_points()
    if capture.points is not None:
        count = int(behind(targets.views, capture.views, capture.points).sum())
        if count:
            console.warn(
                f"{count} of {len(targets.views)} views of the orbit lie behind surfaces that the "
                "cameras saw, as if in or behind a wall. Hint: --targets trajectory"
            )


def _check_appearance(args: argparse.Namespace, method: Method) -> None:
    """Refuse a descriptor that cannot be made, or that the method would not look at."""
    if (args.appearance, args.appearance_weights) == (LAB_HOG, None):
        return
    if "appearance" not in method.reads:
        raise ValueError(
            f"--appearance is {args.appearance}, and {method.name} does not compare frames by "
            "appearance. Hint: leave it out, or --method kmedoids"
        )
    options = ("--appearance", "--appearance-weights")
    check_appearance(args.appearance, args.appearance_weights, options)


def _describing(
    args: argparse.Namespace, seconds: dict[str, float]
) -> Callable[[Capture], np.ndarray]:
    """Description of every frame's appearance, which notes the time that it takes."""

    def timed(capture: Capture) -> np.ndarray:
        started = time.perf_counter()
        images = np.asarray(capture.images)
        appearance = descriptors(images, args.appearance, args.appearance_weights)
        seconds["appearance"] = time.perf_counter() - started
        return appearance

    return timed


def _pictures(
    args: argparse.Namespace, opened: LazyCapture, outcome: record.Outcome
) -> dict[int, bytes]:
    """Pictures of the frames that the report shows, where images are looked at.

    Every frame that is written is decoded, so that none without pixels is handed on.
    """
    files, frames = opened.raw.images, frames_shown(outcome)
    check_pixels([files[i] for i in [*outcome.selection.indices, *outcome.targets.frames]])
    if args.geometry_only:
        return {}
    made = thumbnails([files[i] for i in frames], opened.longest, picture_side(len(frames)))
    return {int(frame): jpeg for frame, jpeg in zip(frames, made, strict=True) if jpeg}
