"""Select frames: the request, the picks, and what is done with them afterwards."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from numbers import Integral
from typing import TYPE_CHECKING

import numpy as np

from fsel.captures.images.previews import sharpness_among
from fsel.captures.images.sharpness import sharpness as measure_sharpness
from fsel.captures.lazy import LazyCapture
from fsel.captures.quality.examination import examined
from fsel.core.capture import Capture, Views
from fsel.core.problem import Method, Problem, checked_select
from fsel.core.subsets import evenly, subset_key
from fsel.core.wording import check_type, counted, listed
from fsel.selection import budget
from fsel.selection.budget import Auto, Budget
from fsel.selection.cover import Cover, check_cover, cover_of, seeing_all
from fsel.selection.focus import Focus
from fsel.selection.frames import Wish
from fsel.selection.problem import Describe, SharpnessOf, as_read, measured, request_problem
from fsel.selection.request import (
    checked_request,
    method_of,
    number_of,
    patience_of,
    without_bad,
)
from fsel.selection.targets import Request, Targets
from fsel.selection.validation import TimeBudget, ValidationResult
from fsel.selectors.policies import Ranked, ScoringMethod

if TYPE_CHECKING:
    from pathlib import Path


@dataclass(frozen=True)
class Selection:
    """Picked frames, best first: the first j are the selection at budget j for nested methods.

    Attributes:
        names: k frame names in pick order.
        indices: (k,) int64 their numbers in the capture.
        scores: (k,) float64 the scorer's value when each was picked; NaN for methods without one.
        seconds: spent selecting, features and what was tried included, images and their sharpness
            excluded.
        budget: how k was found, where it was to be found.
        tried: what was tried on the capture's own frames, or on the targets' images.
        cover: how often the picks see the sparse points, where a cover was stated.
        held_out: (F,) int64 frames that are targets, and were never to be selected.
    """

    names: tuple[str, ...]
    indices: np.ndarray
    scores: np.ndarray
    seconds: float
    budget: Budget | None = None
    tried: ValidationResult | None = None
    cover: Cover | None = None
    held_out: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))

    def __repr__(self) -> str:
        picked = f"{counted(len(self.names), 'frame')}: {listed(self.names)}"
        held_out = f"; {len(self.held_out)} held out" if len(self.held_out) else ""
        return f"Selection({picked}{held_out})"

    def __len__(self) -> int:
        return len(self.names)


def select(
    capture: Capture | LazyCapture,
    k: int | str | Auto | None,
    targets: Request | Targets = None,
    method: str | Method | None = None,
    seed: int = 0,
    *,
    weights: str | Path | None = None,
    patience: float | TimeBudget | None = None,
    cover: int = 0,
    cover_share: float = 1.0,
    sharpness: np.ndarray | SharpnessOf | None = None,
    focus: Focus | None = None,
    descriptors: np.ndarray | Describe | None = None,
    always: Wish = None,
    never: Wish = None,
    keep_bad: bool = False,
) -> Selection:
    """Choose the k frames that best serve the views to be rendered.

    Args:
        capture: a folder, a video (COLMAP finds its poses), a `Capture` (`fsel.read_capture`), a
            `pycolmap.Reconstruction`, or the content of a transforms.json. The last two, whose
            images are sought from the current folder, are selected from by poses and points alone
            where they are not there.
        k: how many frames. `auto`, or `fsel.Auto` with a threshold and a memory of your own: found
            among the first picks of a nested method, see `fsel.selection.budget`. None: as `cover`
            says.
        targets: what will be rendered. None: anything that the capture saw. `every:8`: the frames
            0, 8, 16, ..., which are then never selected; so are frames given by name or number, or
            by a .txt file of names. `orbit`, `trajectory`: a path made from the cameras. A .json
            camera path. `fsel.Views`, or (T, 3, 4) numbers: poses, world to camera with OpenCV
            axes. `Targets`: what `checked_request` returned.
        method: a key of `METHODS`, or a method of your own; None for `fsel`, or what `weights` were
            trained for.
        seed: of methods that draw at random.
        weights: a scorer that the workflow made, in place of one that comes with
            the package.
        patience: seconds in which selections are tried on the capture's own frames, see
            `fsel.selection.halving`; 0 for the rule alone. None: ten where nothing but k is stated,
            neither targets nor a method, an object or frames; else 0. Beside targets that are
            frames, their images are looked at, and score. The same picks are kept on every machine
            that makes the planned reconstructions in that time. Or `fsel.TimeBudget`, to watch
            or end them.
        cover: how often each sparse point that so many frames see is to be seen by the picks, see
            `fsel.selection.multicover`. With k, what is left of it is picked by the method; k of
            None for as few as needed.
        cover_share: of these points. All of them often take nearly all frames, since many points
            are seen by hardly more frames than that.
        sharpness: (N,) of every frame, where it is known already, or what measures it of some;
            else it is measured of the capture's images; for methods that read it.
        descriptors: (N, D) of every frame, where they are known already, or what measures them of
            a capture; else measured by `lab_hog`, which needs no weights; for methods that read
            them.
        focus: an object that targets must see, see `fsel.selection.focus`.
        always, never: names or numbers of frames that are selected first, by methods that score
            frames, and of frames that are not selected; or a file with a name a line.
        keep_bad: whether bad frames may be picked. Else those of a folder, a video or poses are
            left out, as `fsel.bad_frames` names them; a `Capture` is taken as it is.

    Raises:
        ValueError: for a capture of fewer than three frames, k beyond the frames that may be
            selected (with a focus: that see it), an unknown method, weights that are no scorer or
            of another method, a method whose picks are not nested where k is to be found, a memory
            that two frames do not fit, or targets that make no sense for this capture.
        TypeError: for an argument of a type that is none of these.

    Example:
        >>> chosen = fsel.select("captures/garden", 20, targets="every:8")
        >>> chosen.export("garden20")
    """
    named = not (method is None and weights is None)
    check_type("seed", seed, Integral, "a whole number")
    method = method_of(method, weights)
    opened = None
    if isinstance(capture, LazyCapture):
        opened, capture = capture, capture.capture
    if not isinstance(targets, Targets):
        targets = checked_request(capture, k, targets, method, focus, always, never)
    check_cover(cover, cover_share, k, targets, method)
    trying = patience_of(patience, k, targets, method, focus, cover, named=named)
    if opened is not None:
        if not keep_bad:
            health = examined(opened, images=opened.pictured)
            targets, _ = without_bad(targets, health, capture, k)
        capture = as_read(opened, method, k, trying, cover)
        if sharpness is None:
            sharpness = sharpness_among(opened.raw.images, opened.longest)
    sharpness_of = _sharpness_of(capture, sharpness)
    known, descriptors = measured([method], capture, sharpness_of, descriptors)
    ranked = _ranked_by(method, seed)
    number = None if k is None else number_of(k)
    started = time.perf_counter()
    problem = request_problem(capture, targets, known, focus, descriptors)
    if cover:
        problem = seeing_all(problem, number, cover, cover_share)
    count = len(problem.fixed_picks) if number is None else number
    chosen = None
    if isinstance(count, Auto):
        frames, scores, chosen = _enough(problem, targets.views, ranked, count)
    else:
        frames, scores = ranked(problem, count)
    frames, scores, tried = _tried(problem, frames, scores, trying, targets.frames)
    seconds = time.perf_counter() - started
    names = tuple(capture.names[i] for i in frames)
    reached = cover_of(problem, frames, cover, cover_share) if cover else None
    return Selection(names, frames, scores, seconds, chosen, tried, reached, targets.frames)


def _tried(
    problem: Problem,
    frames: np.ndarray,
    scores: np.ndarray,
    patience: TimeBudget,
    targets: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, ValidationResult | None]:
    """The picks of the rule and their scores, or of a selection that the capture itself prefers."""
    if not patience.seconds:
        return frames, scores, None
    from fsel.selection.halving import validated  # here: it imports a reconstructor

    outcome = validated(problem, frames, patience, targets)
    if outcome is None or subset_key(outcome.frames) == subset_key(frames):
        return frames, scores, outcome
    return outcome.frames, np.full(len(frames), np.nan), outcome


def _sharpness_of(capture: Capture, sharpness: np.ndarray | SharpnessOf | None) -> SharpnessOf:
    """Function that says how sharp frames are; see `select`."""
    if sharpness is None:
        return lambda frames: measure_sharpness(capture.images[frames])
    return sharpness if callable(sharpness) else np.asarray(sharpness).__getitem__


def _enough(
    problem: Problem, views: Views, ranked: Ranked, auto: Auto
) -> tuple[np.ndarray, np.ndarray, Budget]:
    """Picks, their scores, and how their number was found.

    The prediction was fitted to few views that picks were made for. So where the whole capture is
    to be rendered, the number is that of picks for some of the views along its path.
    """
    worth = budget.shipped_worth()
    rows = evenly(len(views), budget.WHOLE if problem.targets_unknown else len(views))
    few = replace(problem, targets=views.subset(rows), proxies=problem.proxies[rows])
    shift = budget.view_shift(problem.capture, problem.candidates, few.targets)
    frames, scores = ranked(few, budget.most(shift, auto, worth))
    in_order = shift[np.searchsorted(problem.candidates, frames)]
    chosen = budget.find(in_order, auto, problem.capture.size, worth)
    if problem.targets_unknown:
        frames, scores = ranked(problem, chosen.frames)
    return frames[: chosen.frames], scores[: chosen.frames], chosen


def _ranked_by(method: Method, seed: int) -> Ranked:
    """(problem, k) -> picks and their scores."""
    if isinstance(method, ScoringMethod):
        return method.ranked

    def ranked(problem: Problem, k: int) -> tuple[np.ndarray, np.ndarray]:
        picks = checked_select(method, problem, k, np.random.default_rng(seed))
        return picks, np.full(k, np.nan)

    return ranked
