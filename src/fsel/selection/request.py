"""Arguments of a call: number of frames, method, targets; what is wrong is refused at once."""

from __future__ import annotations

from dataclasses import replace
from numbers import Integral
from pathlib import Path
from types import NoneType

import numpy as np

from fsel.captures.quality import Health
from fsel.core.capture import Capture
from fsel.core.problem import Method
from fsel.core.wording import check_type, counted, unexpected
from fsel.selection.budget import Auto, within
from fsel.selection.focus import Focus
from fsel.selection.frames import Wish
from fsel.selection.targets import ALL, Request, Targets, check_count, targets_of
from fsel.selection.validation import LEAST_TARGETS, TimeBudget
from fsel.selectors import pretrained
from fsel.selectors.policies import RENAMED, ScoringMethod

LEAST_FRAMES = 3
AUTO = "auto"
ALL_FRAMES = "all"  # the method that takes the whole sequence


def number_of(k: int | str | Auto) -> int | Auto:
    """The number of frames, or how it is to be found.

    Raises:
        ValueError: for another word than `auto`.
        TypeError: for anything else.
    """
    if isinstance(k, Integral) and not isinstance(k, bool):
        return int(k)
    if isinstance(k, str) and k != AUTO:
        raise ValueError(f"k is {k!r}; allowed: a number of frames, or {AUTO!r}")
    if not isinstance(k, str | Auto):
        raise unexpected("k", k, f"a whole number, {AUTO!r} or fsel.Auto")
    return k if isinstance(k, Auto) else Auto()


def method_of(method: str | Method | None = None, weights: str | Path | None = None) -> Method:
    """Find the method; arguments and errors are those of `select`."""
    if isinstance(method, Method):
        if weights is not None:
            raise ValueError(f"{weights}: weights go with the name of a method, not with {method}")
        return method
    check_type("method", method, (str, NoneType), "a key of fsel.METHODS, or a Method")
    check_type("weights", weights, (str, Path, NoneType), "a file")
    if weights is not None and method not in RENAMED:
        return pretrained.own(weights, method)
    name = pretrained.DEFAULT if method is None else method
    if name in pretrained.FILES:
        return pretrained.method(name)
    from fsel.evaluation.methods import METHODS  # here: it imports all baselines

    return METHODS.checked(name)


def checked_request(
    capture: Capture,
    k: int | str | Auto | None,
    request: Request,
    method: Method,
    focus: Focus | None = None,
    always: Wish = None,
    never: Wish = None,
) -> Targets:
    """Resolve a request; all that `select` may refuse is refused here, before images are read.

    Arguments and errors are those of `select`; the method is what `method_of` returned.
    """
    number = None if k is None else number_of(k)
    if len(capture) < LEAST_FRAMES:
        raise ValueError(
            f"{capture.source}: {counted(len(capture), 'frame')} would leave nothing to select; "
            f"at least {LEAST_FRAMES} are needed"
        )
    targets = targets_of(capture, request)
    if focus is not None:
        targets = targets.seeing(focus.corners, capture)
    targets = targets.wished(capture, always, never)
    if len(targets.always) and (isinstance(number, Auto) or not isinstance(method, ScoringMethod)):
        said = AUTO if isinstance(number, Auto) else number
        raise ValueError(
            "frames that are always to be selected go with a number of frames, and with a method "
            f"that scores them ({', '.join(pretrained.FILES)}); k is {said}, and the method "
            f"{method.name}"
        )
    if isinstance(number, Auto):
        _check_auto(number, method, capture)
        return targets
    if number is None:
        return targets
    check_count(number, targets, capture, everything=method.name == ALL_FRAMES)
    return targets


def without_bad(
    targets: Targets, health: Health, capture: Capture, k: int | str | Auto | None
) -> tuple[Targets, Health]:
    """Leave bad frames out of the pool of targets, where enough others remain.

    Args:
        targets: what `checked_request` returned.
        health: of the capture's frames.
        capture: the capture.
        k: as many frames remain at least, two where it is to be found; of bad ones the least bad.
    """
    pool = np.setdiff1d(targets.pool(capture), targets.always)
    least = max(int(k) if isinstance(k, Integral) else 0, 2)
    health = health.leaving_out(pool, max(0, len(pool) + len(targets.always) - least))
    return replace(targets, bad=np.sort(health.left_out)), health


def _check_auto(auto: Auto, method: Method, capture: Capture) -> None:
    """Refuse a memory that nothing fits, and methods whose picks are not nested."""
    if auto.memory is not None:
        within(auto.memory, auto.size or capture.size, auto.trainer)
    if not method.nested:
        from fsel.evaluation.methods import METHODS

        nested = ", ".join(name for name, method in METHODS.items() if method.nested)
        raise ValueError(
            f"method is {method.name!r}, whose selection of fewer frames is not the beginning of "
            f"that of more, as finding k needs; allowed: {nested}. Hint: state k"
        )


def patience_of(
    patience: float | TimeBudget | None,
    k: int | str | Auto | None,
    targets: Targets,
    method: Method,
    focus: Focus | None = None,
    cover: int = 0,
    *,
    named: bool,
) -> TimeBudget:
    """Return how long selections are tried on the capture's own frames.

    Args:
        patience: seconds, or None for what is usual: ten where nothing but a number of frames is
            stated, else none.
        k, targets, method, focus, cover: see `select`.
        named: whether the method or its weights were stated.

    Raises:
        ValueError: for a patience below zero, or one where something is stated that leaves nothing
            to try.
    """
    if patience is None:
        stated = stated_beside(k, targets, method, focus, cover)
        return TimeBudget(0) if named or stated else TimeBudget()
    allowed = patience if isinstance(patience, TimeBudget) else TimeBudget(patience)
    shown = len(targets.frames) >= LEAST_TARGETS
    stated = stated_beside(k, targets, method, focus, cover, but_targets=shown)
    if allowed.seconds and stated:
        raise ValueError(
            f"patience is {allowed.seconds:g} s, and {stated}; selections are tried where nothing "
            f"but a number of frames is stated, and targets that are {LEAST_TARGETS} frames or more"
            ". Hint: leave one of the two out"
        )
    return allowed


def stated_beside(
    k: int | str | Auto | None,
    targets: Targets,
    method: Method,
    focus: Focus | None = None,
    cover: int = 0,
    *,
    but_targets: bool = False,
) -> str:
    """Name what is stated beside a number of frames, in words; empty where nothing is."""
    if method.name != pretrained.DEFAULT:
        return f"the method is {method.name}"
    if focus is not None:
        return "an object is stated"
    if targets.kind != ALL and not but_targets:
        return f"the views to be rendered are stated ({targets.kind})"
    if len(targets.always):
        return "frames are stated that are always to be selected"
    if cover or k is None:
        return "a cover of the points is stated"
    return "the number of frames is to be found" if isinstance(number_of(k), Auto) else ""
