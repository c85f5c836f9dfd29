"""The record of a selection: every pick and what it adds, every frame left out and why."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from importlib.metadata import version

import numpy as np

from fsel.captures.colmap.estimator import found_by
from fsel.captures.quality.findings import BLURRED, DUPLICATE, Health
from fsel.core.wording import counted
from fsel.selection.budget import Budget
from fsel.selection.cover import Cover
from fsel.selection.export.outcome import Outcome, closest_pick
from fsel.selection.targets import ALL
from fsel.selection.validation import ValidationResult

RECORD = "selection.json"
PACKAGES = ("fsel", "numpy", "pycolmap")


def picked(outcome: Outcome) -> list[dict]:
    """One entry a pick, in pick order."""
    capture, selection, service = outcome.capture, outcome.selection, outcome.service
    known = outcome.served if outcome.targets.kind == ALL else outcome.targets.frames
    ranks = _sharpness_ranks(outcome.sharpness)
    unsharp = None if ranks is None or outcome.health is None else outcome.health.of_kind(BLURRED)
    sights = outcome.sights
    entries = []
    for order, frame in enumerate(selection.indices):
        view = int(service.nearest_view[order])
        score = float(selection.scores[order])
        entries.append(
            {
                "order": order + 1,
                "name": selection.names[order],
                "index": int(frame),
                "score": score if np.isfinite(score) else None,
                "service": round(float(service.curve[order]), 6),
                "adds": round(float(service.gain[order]), 6),
                "sees_new": None if sights is None else round(float(sights[order]), 6),
                "nearest_target": capture.names[known[view]] if len(known) else view,
                "sharpness_rank": int(ranks[frame]) if ranks is not None else None,
                "blurred": bool(frame in unsharp) if unsharp is not None else None,
            }
        )
    return entries


def left(outcome: Outcome) -> list[dict]:
    """One entry a frame that was not picked, in capture order, with the reason."""
    capture, picks = outcome.capture, outcome.selection.indices
    pool = set(outcome.targets.pool(capture).tolist())
    closest = closest_pick(capture, picks)
    by_rule = _by_rule(outcome, picks)
    entries = []
    for frame in np.setdiff1d(np.arange(len(capture)), picks).tolist():
        near = capture.names[closest[frame]]
        if frame not in pool:
            reason = _left_out(outcome, frame)
        else:
            reason = f"near {near}; {by_rule.get(frame, _by_another(outcome))}"
        entries.append({"name": capture.names[frame], "reason": reason, "closest_pick": near})
    return entries


def unplaced(found: dict | None) -> list[dict]:
    """One entry a frame of a video or photo that was not placed, as `left` has them."""
    if found is None:
        return []
    seconds = {shot["name"]: f", at {shot['seconds']:.1f} s" for shot in found["video"]}
    return [
        {
            "name": name,
            "reason": f"not placed by {found_by(found)}{seconds.get(name, '')}",
            "closest_pick": None,
        }
        for name in found["not_placed"]
    ]


def _by_rule(outcome: Outcome, picks: np.ndarray) -> dict[int, str]:
    """Say what each frame lacks beside the last pick by the rule that picked; nothing by another.

    The rule weighs what a frame shows of the views and how far it lies from the earlier picks.
    """
    known = outcome.standing
    if known is None:
        return {}
    free, last = ~np.isin(known.pool, picks), known.pool == picks[-1]
    shows = known.views[free] - known.views[last]
    apart = known.apart[free] - known.apart[last]
    places = np.empty(free.sum(), np.int64)
    places[np.argsort(-(shows + apart), kind="stable")] = np.arange(1, free.sum() + 1)
    views = "scene" if outcome.targets.kind == ALL else "views"
    than = f"{outcome.selection.names[-1]}, the last pick"
    return {
        int(frame): f"{_lacks(more, farther, views, than)}; place {place} of {free.sum()} in line"
        for frame, more, farther, place in zip(known.pool[free], shows, apart, places, strict=True)
    }


def _lacks(shows: float, apart: float, views: str, than: str) -> str:
    """Compare a frame with the last pick in the two things that the rule weighs."""
    if shows + apart > 0:
        return f"scores more than {than}, which was not picked for its score"
    if shows > 0:
        return f"shows more of the {views} than {than}, but lies too close to earlier picks"
    if apart > 0:
        return f"lies farther from earlier picks than {than}, but shows less of the {views}"
    return f"shows less of the {views} than {than}, and lies closer to earlier picks"


def _by_another(outcome: Outcome) -> str:
    """Name what picked, where it tells no score."""
    tried = outcome.selection.tried
    name = outcome.method.name if tried is None else tried.kept
    return f"the picks of {name} were kept"


def bad_frames(health: Health, names: Sequence[str]) -> list[dict]:
    """One entry a finding: name, kind, value, threshold, what is counted, whether it is left out.

    A bad frame that is not left out alone shows a part of the scene (`alone`), or is wanted, held
    out, or needed to have enough frames. Duplicates may be picked.
    """
    gone, alone = set(health.left_out.tolist()), set(health.alone.tolist())
    return [
        {
            "name": names[finding.frame],
            "kind": finding.kind,
            "value": float(f"{finding.value:.4g}"),
            "threshold": float(f"{finding.threshold:.4g}"),
            "measure": finding.measure,
            "left_out": finding.kind != DUPLICATE and finding.frame in gone,
            "alone": finding.kind != DUPLICATE and finding.frame in alone,
        }
        for finding in health.findings
    ]


def _left_out(outcome: Outcome, frame: int) -> str:
    """Reason why a frame is not one of those that may be selected."""
    targets = outcome.targets
    if outcome.health is not None and frame in targets.bad:
        return "; ".join(str(f) for f in outcome.health.of(frame) if f.kind != DUPLICATE)
    if frame in targets.frames:
        return "held out as a target"
    return "is never to be selected" if frame in targets.never else "sees nothing of the object"


def _sharpness_ranks(sharpness: np.ndarray | None) -> np.ndarray | None:
    """(N,) 1 for the sharpest frame."""
    if sharpness is None:
        return None
    ranks = np.empty(len(sharpness), np.int64)
    ranks[np.argsort(-sharpness, kind="stable")] = np.arange(1, len(sharpness) + 1)
    return ranks


def reason(budget: Budget) -> str:
    """Reason for a number of frames, in words."""
    if budget.within is not None and budget.within < budget.enough:
        return (
            f"{budget.frames} frames, which fit {budget.rule.memory:,} bytes by "
            f"{budget.rule.trainer}; more are predicted to bring up to {budget.missing:.3f} dB "
            f"each, until {budget.enough}"
        )
    return (
        f"{budget.frames} frames: the last is predicted to bring {budget.gain:.3f} dB, and further "
        f"ones less than {budget.rule.threshold:g} dB each"
    )


def trials(tried: ValidationResult) -> str:
    """Describe what was tried on the capture's own frames, in words."""
    known = [trial for trial in tried.trials[1:] if np.isfinite(trial.gain)]
    scores = ", ".join(f"{trial.name} {trial.gain:+.2f}" for trial in known) or "none was scored"
    cut = ", cut off by the time" if tried.cut else ""
    if tried.on_targets:
        own = f"the images of {counted(tried.validation, 'target')}, which were looked at"
    else:
        own = f"{tried.validation} of the capture's own frames"
    first = f"{'the rule' if tried.on_targets else 'every n-th frame'} ({tried.trials[0].name})"
    return (
        f"{counted(len(tried.trials), 'selection')} on {own}, {counted(tried.fits, 'fit')}{cut}; "
        f"kept: {tried.kept}. dB over {first}: {scores}"
    )


def covered(cover: Cover) -> str:
    """Say how often points are seen, in words."""
    part = "each" if cover.share == 1 else f"{cover.share:.0%}"
    full, even = cover.picks[-1] / cover.points, cover.even[-1] / cover.points
    return (
        f"{cover.points:,} points that {counted(cover.times, 'frame')} or more see: "
        f"{counted(cover.frames, 'frame')} are enough to see {part} {cover.times} "
        f"times; the picks see {full:.1%} of them so often, as many frames evenly spaced {even:.1%}"
    )


def versions() -> dict[str, str]:
    """Versions of Python and of the packages that picks depend on."""
    return {"python": platform.python_version()} | {name: version(name) for name in PACKAGES}
