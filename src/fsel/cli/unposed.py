"""`fsel select --no-poses`: frames of a video or of photos, without cameras."""

from __future__ import annotations

import argparse
import math
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from fsel.captures.images import files as image_files
from fsel.captures.lazy import LazyCapture
from fsel.captures.opening import unposed
from fsel.captures.quality.examination import examined
from fsel.captures.quality.findings import DUPLICATE, Health, entries, in_words
from fsel.cli.console import Console
from fsel.cli.open_capture import inputs_of, opening_of
from fsel.core.files import json_text
from fsel.core.outputs import staged
from fsel.core.problem import Method, Problem, checked_select
from fsel.core.registry import Registry
from fsel.core.wording import counted
from fsel.features.appearance import LAB_HOG, descriptors
from fsel.selection.export import placing
from fsel.selectors.baselines import METHODS, PRACTICE, WITHOUT_POSES
from fsel.selectors.baselines.before_poses import farthest

DEFAULT = "best_n"
_HOMES = PRACTICE.homes | METHODS.homes
_NAMES = (*WITHOUT_POSES, "uniform", "sharpest")
POSELESS: Registry[Method] = Registry("method without poses", {n: _HOMES[n] for n in _NAMES})
RECORD, SHEET = "frames.json", "contact_sheet.jpg"
ALLOWED = (
    *("--method", "--keep-bad", "--rate", "--start", "--end", "--skip-unreadable"),
    *("--long-side", "--link", "--out", "--force", "--quiet", "--json", "--poses", "--no-poses"),
)


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    started, method = time.perf_counter(), POSELESS.checked(args.method or DEFAULT)
    stated = [word.partition("=")[0] for word in args.words if word.startswith("--")]
    if wrong := [name for name in stated if not any(o.startswith(name) for o in ALLOWED)]:
        raise ValueError(f"{wrong[0]}: does not go with --no-poses, as {', '.join(ALLOWED)} do")
    if not isinstance(args.k, int):
        raise ValueError("--no-poses needs a number of frames. Hint: -k 48")
    output = staged(args.out, inputs_of(args), args.force)
    with output as stage, TemporaryDirectory(dir=stage) as folder:
        opened = unposed(opening_of(args), Path(folder), console)
        picks, health = _selected(opened, args.k, method, console, args.keep_bad)
        _write(stage, opened, picks, args)
        names = opened.capture.names
        found = entries(health, names)
        content = {
            "source": opened.capture.source,
            "method": method.name,
            "frames": [names[i] for i in picks],
            "bad": [e | {"left_out": e["left_out"] or e["kind"] == DUPLICATE} for e in found],
            "seconds": round(time.perf_counter() - started, 4),
        }
        (stage / RECORD).write_text(json_text(content), encoding="utf-8")
    said = f"{counted(len(picks), 'frame')} of {len(names)} by {method.name}"
    console.say("written", f"{args.out}: {said} after {content['seconds']:.2f} s")
    console.give(content)


def _selected(
    opened: LazyCapture, k: int, method: Method, console: Console, keep_bad: bool
) -> tuple[np.ndarray, Health]:
    """Pick k frames of what `unposed` opened, and return them with the health of all.

    Duplicates are left out, and bad frames as long as k others remain. The first pick is the one
    that the others resemble most, each next one the least like those before it.
    """
    health, names = examined(opened, console.bar("health")), opened.capture.names
    if keep_bad:
        health = Health(sharpness=health.sharpness)
    frames = np.setdiff1d(np.arange(len(names)), health.of_kind(DUPLICATE))
    if not 1 <= k <= len(frames):
        said = f"{opened.capture.source}: k is {k}; allowed: 1 to {len(frames)}, frames that differ"
        raise ValueError(f"{said}. Hint: --rate takes more of a video")
    health = health.leaving_out(frames, len(frames) - k)
    for line in in_words(health, names):
        console.say(*line)
    pool = np.setdiff1d(frames, health.left_out)
    capture = opened.loaded(np.arange(len(names)), console.bar("images"))
    described = descriptors(capture.images, LAB_HOG)
    known = np.nan_to_num(np.zeros(len(names)) if health.sharpness is None else health.sharpness)
    problem = Problem(capture, pool, pool[:0], capture.view(pool[:0]), described, known)
    picks = checked_select(method, problem, k, np.random.default_rng(0))
    return picks[farthest(described[picks], k)], health


def _write(stage: Path, opened: LazyCapture, picks: np.ndarray, args: argparse.Namespace) -> None:
    """Write the list, the images under names in the order of the picks, and the contact sheet."""
    names = [opened.capture.names[i] for i in picks]
    (stage / "frames.txt").write_text("".join(f"{n}\n" for n in names), encoding="utf-8")
    for place, (frame, name) in enumerate(zip(picks, names, strict=True)):
        file, size = opened.raw.images[frame], None
        width, height = image_files.size_of(file)
        if (scale := (args.long_side or np.inf) / max(width, height)) < 1:
            size = max(1, round(width * scale)), max(1, round(height * scale))
        path = stage / "images" / f"{place:04d}_{name.replace('/', '_')}"
        placing.place(file, path, args.link, size)
    shown = opened.capture.images[picks]
    columns = math.isqrt(len(picks) - 1) + 1
    blank = np.full((-len(picks) % columns, *shown.shape[1:]), 255, np.uint8)
    page = np.concatenate([shown, blank]).reshape(-1, columns, *shown.shape[1:])
    page = np.concatenate(np.concatenate(list(page), axis=1), axis=1)
    image_files.write(page[None], stage, [SHEET])
