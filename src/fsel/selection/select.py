"""Select frames as a request says."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from fsel.captures.images.previews import sharpness as measure_sharpness
from fsel.captures.images.previews import sharpness_among
from fsel.captures.lazy import LazyCapture, of_capture
from fsel.captures.quality.examination import examined
from fsel.captures.quality.findings import Health, in_words
from fsel.captures.reporter import SILENT, Reporter
from fsel.core.capture import Capture
from fsel.core.problem import Method, Problem, checked_select
from fsel.core.subsets import subset_key
from fsel.selection import budget
from fsel.selection.budget import Auto
from fsel.selection.outcome import Outcome, Selection
from fsel.selection.panoramas import by_panorama
from fsel.selection.problem import measured, request_problem, with_target_depths
from fsel.selection.request import CheckedRequest, SharpnessOf
from fsel.selection.targets import Targets
from fsel.selectors.policies import Ranked, ScoringMethod


def select_frames(checked: CheckedRequest, reporter: Reporter = SILENT) -> Outcome:
    """Select the frames of a request; the reporter names bad frames, and shows progress."""
    request, opened = checked.request, checked.request.opened
    targets, number, health, found = checked.targets, checked.k, None, None
    began, filed = time.perf_counter(), opened or of_capture(checked.capture)
    if filed is not None and not request.keep_bad:
        health = examined(filed, reporter.bar("health"), images=request.pictured)
        targets, health = without_bad(targets, checked.capture, checked.k, health, reporter)
    if isinstance(number, Auto):
        pool = len(targets.pool(checked.capture))
        found = budget.find(number, pool, checked.capture.size)
        number = found.frames
    targets = targets.with_stand_ins(checked.capture, number)
    examined_at = time.perf_counter()
    tracks = targets.as_many_as(number) or checked.method.tracks or checked.patience.seconds > 0
    capture = checked.capture if opened is None else _as_read(checked, opened, tracks, reporter)
    sharpness_of = _sharpness_of(checked, reporter)
    read = measured([checked.method], capture, sharpness_of, request.descriptors)
    seconds = {"health": examined_at - began, "images": time.perf_counter() - examined_at}
    checked = replace(checked, targets=targets)
    selection, problem = _selection(checked, number, capture, *read)
    selection = replace(selection, budget=found)
    seconds["select"] = selection.seconds
    outcome = Outcome(capture, targets, selection, problem, checked.method, health, seconds)
    gap = outcome.gap
    if gap is not None and gap.wide:
        reporter.warn(str(gap))
    return outcome


def without_bad(
    targets: Targets, capture: Capture, k: int | Auto, health: Health, reporter: Reporter
) -> tuple[Targets, Health]:
    """Leave the bad frames of a capture out of what may be selected, and report them.

    At least `k` frames remain, two where it is to be found: of bad ones the least bad.
    """
    pool = np.setdiff1d(targets.pool(capture), targets.always)
    least = max(k if isinstance(k, int) else 0, 2)
    health = health.leaving_out(pool, max(0, len(pool) + len(targets.always) - least))
    for line in in_words(health, capture.names):
        reporter.say(*line)
    return replace(targets, bad=np.sort(health.left_out)), health


def _selection(
    checked: CheckedRequest,
    number: int,
    capture: Capture,
    sharpness: np.ndarray,
    descriptors: np.ndarray | None,
) -> tuple[Selection, Problem]:
    """Pick frames of a capture that was read; the seconds that it takes count."""
    started, request, targets = time.perf_counter(), checked.request, checked.targets
    ranked = _ranked_by(checked.method, request.seed)
    if checked.panorama is not None:
        stepwise = isinstance(checked.method, ScoringMethod)
        ranked = by_panorama(ranked, checked.panorama, stepwise=stepwise)
    problem = request_problem(capture, targets, sharpness, checked.focus, descriptors)
    if request.opened is not None:
        problem = replace(problem, seconds=request.opened.seconds)
    if targets.as_many_as(number):
        problem = with_target_depths(problem)
    frames, scores = ranked(problem, number)
    tried = None
    if checked.patience.seconds and len(problem.fixed_picks) < len(frames):
        from fsel.selection.halving import validated  # here: it imports a reconstructor

        tried = validated(problem, frames, checked.patience, targets.frames)
    if tried is not None and subset_key(tried.frames) != subset_key(frames):
        frames, scores = tried.frames, np.full(len(frames), np.nan)
    seconds = time.perf_counter() - started
    names = tuple(capture.names[i] for i in frames)
    own = (None, tried, targets.frames)
    return Selection(names, frames, scores, seconds, checked.capture, *own), problem


def _as_read(
    checked: CheckedRequest, opened: LazyCapture, tracks: bool, reporter: Reporter
) -> Capture:
    """Return the capture with what the selection reads of it."""
    if {"appearance", "images"} & set(checked.method.reads):
        return opened.loaded(np.arange(len(opened.capture)), reporter.bar("images"))
    with reporter.clock("points"):
        return opened.with_all_points() if tracks else opened.capture


def _sharpness_of(checked: CheckedRequest, reporter: Reporter) -> SharpnessOf:
    """Return what says how sharp frames are; zeros where images are not looked at."""
    request, opened = checked.request, checked.request.opened
    if request.sharpness is not None:
        known = request.sharpness
        return known if callable(known) else np.asarray(known).__getitem__
    if not request.pictured:
        return lambda frames: np.zeros(len(frames))
    if opened is not None:
        return sharpness_among(opened.raw.images, opened.longest, reporter.bar("sharpness"))
    return lambda frames: measure_sharpness(checked.capture.images[frames])


def _ranked_by(method: Method, seed: int) -> Ranked:
    """Return what makes (problem, k) -> picks and their scores."""
    if isinstance(method, ScoringMethod):
        return method.ranked
    return lambda problem, k: (
        checked_select(method, problem, k, np.random.default_rng(seed)),
        np.full(k, np.nan),
    )
