"""What a person asks for, validated in one place before any image is opened."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from numbers import Integral
from pathlib import Path
from types import NoneType

import numpy as np

from fsel.captures.lazy import LazyCapture
from fsel.core.capture import Capture
from fsel.core.problem import Method
from fsel.core.wording import check_type, counted, unexpected
from fsel.selection.budget import Auto, within
from fsel.selection.focus import Focus, focus_of, from_box
from fsel.selection.frames import Wish, is_stated
from fsel.selection.panoramas import panorama_of
from fsel.selection.targets import ALL, Request, Targets, check_count, check_targets, targets_of
from fsel.selection.validation import DEFAULT, KNOWN, LEAST_TARGETS, TimeBudget
from fsel.selectors import pretrained

LEAST_FRAMES = 3
AUTO = "auto"
ALL_FRAMES = "all"  # the method that takes the whole sequence

Describe = Callable[[Capture], np.ndarray]
"""capture -> (N, D) float32 appearance descriptors of every frame."""
SharpnessOf = Callable[[np.ndarray], np.ndarray]
"""(n,) int64 frames -> (n,) sharpness of each, comparable within a call."""


@dataclass(frozen=True)
class SelectionRequest:
    """A selection that a person wants, by the arguments of `fsel.select`; `checked_request` says
    whether it can be made.

    Without a `source`, the capture is yet to be opened. Without `images`, nothing is tried and
    nothing measured.
    """

    source: Capture | LazyCapture | None
    k: int | str | Auto
    targets: Request = None
    method: str | Method | None = None
    seed: int = 0
    weights: str | Path | None = None
    patience: float | TimeBudget | None = None
    sharpness: np.ndarray | SharpnessOf | None = None
    focus: Focus | str | Path | Sequence[float] | None = None
    descriptors: np.ndarray | Describe | None = None
    always: Wish = None
    never: Wish = None
    keep_bad: bool = False
    images: bool = True
    views: bool = False

    @property
    def opened(self) -> LazyCapture | None:
        """The capture with its files, where it was opened from files."""
        return self.source if isinstance(self.source, LazyCapture) else None

    @property
    def capture(self) -> Capture:
        """The capture to select from."""
        if self.source is None:
            raise ValueError("the capture of a request is not opened yet")
        return self.source if isinstance(self.source, Capture) else self.source.capture

    @property
    def pictured(self) -> bool:
        """Whether there are images, and they may be looked at."""
        return self.images and (self.opened is None or self.opened.pictured)


@dataclass(frozen=True)
class CheckedRequest:
    """A request that can be served, and what its words stand for; `panorama` is the number of each
    frame's, (N,), where they are picked whole."""

    request: SelectionRequest
    capture: Capture
    k: int | Auto
    targets: Targets
    method: Method
    focus: Focus | None
    patience: TimeBudget
    panorama: np.ndarray | None = None


def checked_request(request: SelectionRequest) -> CheckedRequest:
    """Resolve a request; all that a selection may refuse is refused here, before work."""
    method, k = vet(request)
    opened, capture = request.opened, request.capture
    if opened is not None and not opened.pictured and "sharpness" in method.reads:
        capture.images[0]  # refused
    if len(capture) < LEAST_FRAMES:
        raise ValueError(
            f"{capture.source}: too few to select from: {counted(len(capture), 'frame')}; "
            f"at least {LEAST_FRAMES} are needed"
        )
    focus = focus_of(request.focus, capture if opened is None else opened)
    targets = targets_of(capture, request.targets)
    if focus is not None:
        targets = targets.seeing(focus.corners, capture)
    targets = targets.wished(capture, request.always, request.never)
    number = panorama_of(capture)
    if request.views and number is None:
        raise ValueError(f"{capture.source}: `views=True` is for panoramas; it has none")
    number = None if request.views else number
    if number is not None and not isinstance(k, int):
        raise ValueError(
            f"{capture.source}: of panoramas a number k is picked. Hint: `views=True` picks "
            "their views one by one"
        )
    checked = CheckedRequest(request, capture, k, targets, method, focus, TimeBudget(0), number)
    if isinstance(k, int):
        check_count(k, targets, capture, number, everything=method.name == ALL_FRAMES)
    elif k.memory is not None:
        within(k.memory, k.size or capture.size, k.trainer)
    return replace(checked, patience=_time_budget(checked))


def vet(request: SelectionRequest) -> tuple[Method, int | Auto]:
    """Refuse what needs no capture to be refused; return the method, and the number of frames.

    The files that a request names are looked for: finding poses may take an hour.
    """
    check_type("seed", request.seed, Integral, "a whole number")
    method = method_of(request.method, request.weights)
    k = number_of(request.k)
    if isinstance(k, int) and k < 1:
        raise ValueError(f"k is {k}; allowed: 1 or more frames, fewer than the capture has")
    check_targets(request.targets)
    is_stated(request.never)
    if not isinstance(request.focus, str | Path | Focus | NoneType):
        from_box(np.asarray(request.focus))
    elif isinstance(request.focus, str | Path) and not Path(request.focus).is_dir():
        raise FileNotFoundError(f"{request.focus}: no such folder of masks")
    _check_number(request, k, method)
    return method, k


def number_of(k: int | str | Auto) -> int | Auto:
    """Return the number of frames, or how it is to be found."""
    if isinstance(k, Integral) and not isinstance(k, bool):
        return int(k)
    if isinstance(k, str) and k != AUTO:
        raise ValueError(f"k is {k!r}; allowed: a number of frames, or {AUTO!r}")
    if not isinstance(k, str | Auto):
        raise unexpected("k", k, f"a whole number, {AUTO!r} or fsel.Auto")
    return k if isinstance(k, Auto) else Auto()


def method_of(method: str | Method | None = None, weights: str | Path | None = None) -> Method:
    """Find a method as `fsel.select` does."""
    if isinstance(method, Method):
        if weights is not None:
            raise ValueError(f"{weights}: weights go with the name of a method, not with {method}")
        return method
    check_type("method", method, (str, NoneType), "a key of fsel.METHODS, or a Method")
    check_type("weights", weights, (str, Path, NoneType), "a file")
    if weights is not None:
        return pretrained.own(weights, method)
    name = pretrained.DEFAULT if method is None else method
    if name in pretrained.FILES:
        return pretrained.method(name)
    from fsel.evaluation.methods import METHODS  # here: it imports all baselines

    return METHODS.checked(name)


def _check_number(request: SelectionRequest, k: int | Auto, method: Method) -> None:
    """Refuse frames to keep where the number is to be found, or the method does not begin so."""
    auto = isinstance(k, Auto)
    if is_stated(request.always) and (auto or not method.begins):
        raise ValueError(
            "`always=NAMES` needs a number of frames and a method that begins "
            f"with them ({', '.join(pretrained.FILES)}); k is {AUTO if auto else k}, and the "
            f"method {method.name}"
        )


def _time_budget(checked: CheckedRequest) -> TimeBudget:
    """Return the time for validation; refuse one if there is nothing to validate."""
    request, stated = checked.request, checked.request.patience
    beside = _stated_beside(checked)
    if stated is None:
        named = not (request.method is None and request.weights is None)
        few = isinstance(checked.k, int) and checked.k <= len(checked.targets.frames)
        plain = named or beside or not request.pictured
        return TimeBudget(0 if plain else KNOWN if few else DEFAULT)
    patience = stated if isinstance(stated, TimeBudget) else TimeBudget(stated)
    if not patience.seconds:
        return patience
    if not request.pictured:
        raise ValueError("--patience reconstructs from images, which --geometry-only does not read")
    if beside:
        raise ValueError(
            f"patience is {patience.seconds:g} s, but {beside}; selections are validated only with "
            f"a number of frames alone, or with {LEAST_TARGETS} or more frames as targets. "
            "Hint: drop one of the two"
        )
    return patience


def _stated_beside(checked: CheckedRequest) -> str:
    """Name what is stated beside a number of frames, or targets whose images judge; else empty."""
    targets = checked.targets
    if checked.method.name != pretrained.DEFAULT:
        return f"the method is {checked.method.name}"
    if checked.panorama is not None:
        return "panoramas are picked"
    if checked.focus is not None:
        return "an object is given"
    if targets.kind != ALL and len(targets.frames) < LEAST_TARGETS:
        return f"the views to render are given ({targets.kind})"
    return ""
