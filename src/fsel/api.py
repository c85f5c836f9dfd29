"""The library's face: select frames, fit a reconstruction to them, evaluate it."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np

from fsel.capture import Capture, Views
from fsel.features.sharpness import sharpness as measure_sharpness
from fsel.problem import Method, Problem, checked_select
from fsel.request import budget
from fsel.request.blur import SharpnessOf, exchanged
from fsel.request.budget import Auto, Budget
from fsel.request.focus import Focus
from fsel.request.memory import within
from fsel.request.problem import request_problem
from fsel.request.refine import Refine, Swapped
from fsel.request.targets import Request, Targets, Wish, check_count, targets_of
from fsel.selector import pretrained
from fsel.selector.policies import Learned, Ranked
from fsel.subsets import evenly

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import ArrayLike

    from fsel.metrics import Metrics
    from fsel.reconstruct import Model
    from fsel.reconstruct.splats.reconstructor import SplatModel

LEAST_FRAMES = 3
AUTO = "auto"
ALL_FRAMES = "all"  # the method that takes the whole sequence


@dataclass(frozen=True)
class Selection:
    """Picked frames, best first: the first j are the selection at budget j for nested methods.

    Attributes:
        names: k frame names in pick order.
        indices: (k,) int64 their numbers in the capture.
        scores: (k,) float64 the scorer's value when each was picked; NaN for methods without one.
        seconds: spent selecting, features included, images and their sharpness excluded.
        budget: how k was found, where it was to be found.
        swapped: what swaps changed and gained, where they were asked for. Then fewer picks are no
            longer the selection at a smaller budget, and a frame that was swapped in has no score.
        exchanged: name of a pick -> that of the blurred one whose place it took. At a smaller
            budget another frame may take it, since fewer are picked already.
    """

    names: tuple[str, ...]
    indices: np.ndarray
    scores: np.ndarray
    seconds: float
    budget: Budget | None = None
    swapped: Swapped | None = None
    exchanged: dict[str, str] = field(default_factory=dict)


def select(
    capture: Capture,
    k: int | str | Auto,
    targets: Request | Targets = None,
    method: str | Method | None = None,
    seed: int = 0,
    *,
    weights: str | Path | None = None,
    refine: float | Refine | None = None,
    sharpness: np.ndarray | SharpnessOf | None = None,
    focus: Focus | None = None,
    descriptors: np.ndarray | None = None,
    always: Wish = None,
    never: Wish = None,
) -> Selection:
    """Choose the k frames that best serve the views to be rendered.

    Args:
        capture: what `read_capture` returns.
        k: how many frames. `auto`, or `fsel.Auto` with a threshold and a memory of your own: found
            among the first picks of a nested method, see `fsel.request.budget`.
        targets: what will be rendered. None: anything that the capture saw. `every:8`: the frames
            0, 8, 16, ..., which are then never selected; so are frames given by name or number, or
            by a .txt file of names. `orbit`, `trajectory`: a path made from the cameras. A .json
            camera path. `fsel.capture.Views`: poses. `Targets`: what `checked_request` returned.
        method: a key of `METHODS`, or a method of your own; None for `fsel`, or what `weights` were
            trained for.
        seed: of methods that draw at random.
        weights: a scorer that `fsel train` or the workflow made, in place of one that comes with
            the package.
        refine: seconds in which swaps are tried that real reconstructions of the capture judge, see
            `fsel.request.swaps`; the more, the better the picks. Or `fsel.Refine`, to watch or end
            them.
        sharpness: (N,) of every frame, where it is known already, or what measures it of some;
            else it is measured of the capture's images, of all for methods that read it. Blurred
            picks of `fsel` are exchanged, see `fsel.request.blur`; zeros exchange none.
        descriptors: (N, D) of every frame, where they are known already; else measured for methods
            that read them, by `lab_hog`, which needs no weights.
        focus: an object that targets must see, see `fsel.request.focus`.
        always, never: names or numbers of frames that are selected first, by methods that score
            frames, and of frames that are not selected; or a file with a name a line.

    Raises:
        ValueError: for a capture of fewer than three frames, k beyond the frames that may be
            selected (with a focus: that see it), an unknown method, weights that are no scorer or
            of another method, a method whose picks are not nested where k is to be found, a memory
            that two frames do not fit, or targets that make no sense for this capture.

    Example:
        >>> capture = fsel.read_capture("captures/garden")
        >>> fsel.select(capture, 20, targets="every:8").names
    """
    method = method_of(method, weights)
    if not isinstance(targets, Targets):
        targets = checked_request(capture, k, targets, method, focus, always, never)
    sharpness_of = _sharpness_of(capture, sharpness)
    known = np.zeros(len(capture))
    if "sharpness" in method.reads:
        known = sharpness_of(np.arange(len(capture)))
    if descriptors is None and "appearance" in method.reads:
        descriptors = described(capture)
    ranked = _ranked_by(method, seed)
    asked = number_of(k)
    started = time.perf_counter()
    problem = request_problem(capture, targets, known, focus, descriptors)
    found = None
    if isinstance(asked, Auto):
        frames, scores, found = _enough(problem, targets.views, ranked, asked)
    else:
        frames, scores = ranked(problem, asked)
    seconds, began, swapped = time.perf_counter() - started, frames, None
    sharp = sharpened(method, problem, frames, sharpness_of)
    started = time.perf_counter()
    frames = sharp
    if refine is not None:
        if len(targets.always):
            raise ValueError("frames that are always to be selected cannot be swapped: no refine")
        from fsel.request.swaps import refined  # here: most selections reconstruct nothing

        patience = refine if isinstance(refine, Refine) else Refine(refine)
        swapped = refined(problem, frames, patience, seed)
        frames = swapped.picks
    scores = np.where(frames == began, scores, np.nan)
    seconds += time.perf_counter() - started
    names = tuple(capture.names[i] for i in frames)
    stand_in = (sharp != began) & (frames == sharp)  # swaps may have taken it out again
    instead = {names[at]: capture.names[began[at]] for at in np.flatnonzero(stand_in)}
    return Selection(names, frames, scores, seconds, found, swapped, instead)


def sharpened(
    method: Method, problem: Problem, frames: np.ndarray, sharpness_of: SharpnessOf
) -> np.ndarray:
    """(K,) a method's picks; of `fsel` the blurred ones exchanged, see `fsel.request.blur`."""
    return exchanged(problem, frames, sharpness_of) if method.name == pretrained.DEFAULT else frames


def _sharpness_of(capture: Capture, sharpness: np.ndarray | SharpnessOf | None) -> SharpnessOf:
    """What says how sharp frames are; see `select`."""
    if sharpness is None:
        return lambda frames: measure_sharpness(capture.images[frames])
    return sharpness if callable(sharpness) else np.asarray(sharpness).__getitem__


def number_of(k: int | str | Auto) -> int | Auto:
    """The number of frames, or how it is to be found.

    Raises:
        ValueError: for another word than `auto`.
    """
    if not isinstance(k, str):
        return k
    if k != AUTO:
        raise ValueError(f"k is {k!r}; allowed: a number of frames, or {AUTO!r}")
    return Auto()


def _enough(
    problem: Problem, views: Views, ranked: Ranked, auto: Auto
) -> tuple[np.ndarray, np.ndarray, Budget]:
    """Picks, their scores, and how their number was found.

    The prediction was fitted to few views that picks were made for. So where the whole capture is
    asked for, the number is that of picks for some of the views along its path.
    """
    worth = budget.shipped_worth()
    rows = evenly(len(views), budget.WHOLE if problem.whole else len(views))
    few = replace(problem, targets=views.subset(rows), proxies=problem.proxies[rows])
    shift = budget.view_shift(problem.capture, problem.candidates, few.targets)
    frames, scores = ranked(few, budget.most(shift, auto, worth))
    in_order = shift[np.searchsorted(problem.candidates, frames)]
    found = budget.find(in_order, auto, problem.capture.size, worth)
    if problem.whole:
        frames, scores = ranked(problem, found.frames)
    return frames[: found.frames], scores[: found.frames], found


def method_of(method: str | Method | None = None, weights: str | Path | None = None) -> Method:
    """The method that is asked for; arguments and errors are those of `select`."""
    if isinstance(method, Method):
        if weights is not None:
            raise ValueError(f"{weights}: weights go with the name of a method, not with {method}")
        return method
    if weights is not None:
        return pretrained.own(weights, method)
    name = pretrained.DEFAULT if method is None else method
    if name in pretrained.FILES:
        return pretrained.method(name)
    from fsel.methods import METHODS  # here: it imports all baselines

    return METHODS.checked(name)


def _ranked_by(method: Method, seed: int) -> Ranked:
    """(problem, k) -> picks and their scores."""
    if isinstance(method, Learned):
        return method.ranked

    def ranked(problem: Problem, k: int) -> tuple[np.ndarray, np.ndarray]:
        picks = checked_select(method, problem, k, np.random.default_rng(seed))
        return picks, np.full(k, np.nan)

    return ranked


def checked_request(
    capture: Capture,
    k: int | str | Auto,
    request: Request,
    method: Method,
    focus: Focus | None = None,
    always: Wish = None,
    never: Wish = None,
) -> Targets:
    """What a request means; all that `select` may refuse is refused here, before images are read.

    Arguments and errors are those of `select`; the method is what `method_of` returned.
    """
    asked = number_of(k)
    if len(capture) < LEAST_FRAMES:
        raise ValueError(
            f"{capture.source}: {len(capture)} frames leave nothing to select; at least "
            f"{LEAST_FRAMES} are needed"
        )
    targets = targets_of(capture, request)
    if focus is not None:
        targets = targets.seeing(focus.corners, capture)
    targets = targets.wished(capture, always, never)
    if len(targets.always) and (isinstance(asked, Auto) or not isinstance(method, Learned)):
        raise ValueError(
            "frames that are always to be selected go with a number of frames, and with a method "
            f"that scores them ({', '.join(pretrained.FILES)}); k is {asked}, by {method.name}"
        )
    if isinstance(asked, Auto):
        _check_auto(asked, method, capture)
        return targets
    check_count(asked, targets, capture, everything=method.name == ALL_FRAMES)
    return targets


def _check_auto(auto: Auto, method: Method, capture: Capture) -> None:
    """Refuse a memory that nothing fits, and methods whose picks are not nested."""
    if auto.memory is not None:
        within(auto.memory, auto.size or capture.size, auto.trainer)
    if not method.nested:
        from fsel.methods import METHODS

        nested = ", ".join(name for name, found in METHODS.items() if found.nested)
        raise ValueError(
            f"method is {method.name!r}, whose selection of fewer frames is not the beginning of "
            f"that of more, as finding k needs; allowed: {nested}. Hint: state k"
        )


def described(capture: Capture) -> np.ndarray:
    """(N, D) float32 appearance descriptors of every frame, which need no weights."""
    from fsel.features.appearance import descriptors

    return descriptors(np.asarray(capture.images), "lab_hog")


@overload
def fit(
    capture: Capture,
    frames: ArrayLike,
    reconstructor: Literal["splats"] = "splats",
    **settings: Any,
) -> SplatModel: ...


@overload
def fit(capture: Capture, frames: ArrayLike, reconstructor: str, **settings: Any) -> Model: ...


def fit(
    capture: Capture, frames: ArrayLike, reconstructor: str = "splats", **settings: Any
) -> Model:
    """Reconstruct a capture's scene from some of its frames.

    Args:
        capture: at the size to reconstruct at: the `long_side` of `fsel.read_capture`.
        frames: numbers of two or more distinct frames.
        reconstructor: a key of `RECONSTRUCTORS`.
        settings: of the reconstructor.

    Returns:
        A model: `render(views)` gives (T, h, w, 3) float32 images; that of `splats` also has
        `export_ply(path)`, which writes standard Gaussian splats.

    Raises:
        ValueError: for an unknown reconstructor, fewer than two frames, or repeated ones.
        ImportError: when the reconstructor needs a package that is not installed.
    """
    from fsel.reconstruct import RECONSTRUCTORS

    factory = RECONSTRUCTORS.checked(reconstructor)
    return factory(capture, **settings).fit(np.asarray(frames, np.int64))


def evaluate(
    capture: Capture, model: Model, targets: ArrayLike, metrics: Metrics | None = None
) -> dict[str, np.ndarray]:
    """Compare a model's renderings with frames that it was not made from.

    Args:
        capture: what the model was made from, at the same size.
        model: what `fit` returns.
        targets: (T,) numbers of held-out frames.
        metrics: keys of `fsel.metrics.REGISTERED`, or key -> settings, as
            `{"psnr": {}, "lpips": {"net": "alex", "weights": path}}`; None for `psnr` in dB, `ssim`
            and `gmsd` (lower is better).

    Returns:
        Metric -> (T,) float64.

    Raises:
        ValueError, FileNotFoundError, ImportError: for an unknown metric, or what one refuses.
    """
    from fsel.metrics import METRICS, checked, score_views

    asked = METRICS if metrics is None else checked(metrics)
    frames = np.asarray(targets, np.int64)
    truth = np.asarray(capture.images[frames])
    scores = score_views(model.render(capture.view(frames)), truth, None, asked)
    return dict(zip(asked, scores.T, strict=True))
