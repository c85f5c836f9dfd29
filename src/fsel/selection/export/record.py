"""The record of a selection: every pick and what it adds, every frame left out and why."""

from __future__ import annotations

import platform
from collections import Counter
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

import numpy as np

from fsel.captures.lazy import LazyCapture
from fsel.captures.quality import findings
from fsel.captures.quality.findings import BLURRED, DUPLICATE
from fsel.core.geometry import pose_distance
from fsel.core.problem import Method
from fsel.core.wording import counted
from fsel.selection.budget import Budget
from fsel.selection.export.subset import Form
from fsel.selection.outcome import Outcome
from fsel.selection.targets import ALL
from fsel.selection.validation import ValidationResult
from fsel.selectors.policies import ScoringMethod
from fsel.selectors.pretrained import DEFAULT
from fsel.selectors.scorer import Linear

RECORD = "selection.json"
LEAST_SAID = 0.05  # dB that a selection is ahead by, to be said
LONGER = 3  # times the patience that a hint proposes
PACKAGES = ("fsel", "numpy", "pycolmap")


def content(
    outcome: Outcome, opened: LazyCapture, form: Form, stated: dict[str, Any]
) -> dict[str, Any]:
    """Return the content of selection.json; its seconds are those of selecting.

    `stated["capture"]` says where the capture is and how it was opened, `"settings"` the options.
    """
    selection, targets, health = outcome.selection, outcome.targets, outcome.health
    budget, names = selection.budget, opened.capture.names
    capture = {"layout": opened.layout, "frames": len(names), "dropped": opened.raw.dropped}
    return {
        "capture": stated["capture"] | capture | {"placed": _placed(opened.found)},
        "targets": {
            "kind": targets.kind,
            "views": len(targets.views),
            "held_out": [names[i] for i in targets.frames],
            "far": int(targets.far.sum()),
        },
        "settings": stated["settings"] | {"method": outcome.method.name},
        "tried": None if selection.tried is None else _validation(selection.tried),
        "budget": None if budget is None else asdict(budget) | {"reason": reason(budget)},
        "scorer": _scorer(outcome.method),
        "versions": {"python": platform.python_version()} | {p: version(p) for p in PACKAGES},
        "seconds": outcome.seconds,
        "frames": picked(outcome),
        "left": left(outcome) + unplaced(opened.found),
        "bad": None if health is None else findings.entries(health, names),
        "gap": _gap(outcome),
    }


def picked(outcome: Outcome) -> list[dict]:
    """One entry a pick, in pick order."""
    capture, selection, shift = outcome.capture, outcome.selection, outcome.mean_shift
    adds, nearest = -np.diff(shift, prepend=1.0), outcome.shift.argmin(axis=1)
    known = outcome.served if outcome.targets.kind == ALL else outcome.targets.frames
    ranks = unsharp = None
    if outcome.health is not None and outcome.sharpness is not None:
        unsharp = outcome.health.of_kind(BLURRED)
        ranks = np.argsort(np.argsort(-outcome.sharpness, kind="stable")) + 1  # 1: the sharpest
    sights = outcome.sights
    entries = []
    for order, frame in enumerate(selection.indices):
        view = int(nearest[order])
        score = float(selection.scores[order])
        entries.append(
            {
                "order": order + 1,
                "name": selection.names[order],
                "index": int(frame),
                "score": score if np.isfinite(score) else None,
                "shift": round(float(shift[order]), 6),
                "adds": round(float(adds[order]), 6),
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
    centers, axes = capture.centers, capture.axes
    closest = picks[pose_distance(centers, axes, centers[picks], axes[picks]).argmin(axis=1)]
    by_rule, tried = _by_rule(outcome, picks), outcome.selection.tried
    kept = f"the picks of {outcome.method.name if tried is None else tried.kept} were kept"
    entries = []
    for frame in np.setdiff1d(np.arange(len(capture)), picks).tolist():
        near = capture.names[closest[frame]]
        why = f"near {near}; {by_rule.get(frame, kept)}"
        reason = why if frame in pool else _left_out(outcome, frame)
        entries.append({"name": capture.names[frame], "reason": reason, "closest_pick": near})
    return entries


def unplaced(found: dict | None) -> list[dict]:
    """One entry a frame of a video or photo that was not placed, as `left` has them."""
    if found is None:
        return []
    seconds = {shot["name"]: f", at {shot['seconds']:.1f} s" for shot in found["video"]}
    why = f"not placed by {found['by']}"
    return [
        {"name": name, "reason": why + seconds.get(name, ""), "closest_pick": None}
        for name in found["not_placed"]
    ]


def _gap(outcome: Outcome) -> dict | None:
    """Describe the largest gap between the picks, in fields of view."""
    gap = outcome.gap
    if gap is None:
        return None
    numbers = {"shift": round(gap.shift, 4), "usual": round(gap.usual, 4)}
    return {"name": gap.name, "wide": gap.wide} | numbers


def _by_rule(outcome: Outcome, picks: np.ndarray) -> dict[int, str]:
    """Return what each frame lacks compared with the last pick, if a rule picked."""
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
    reasons = {}
    for frame, more, farther, place in zip(known.pool[free], shows, apart, places, strict=True):
        if more + farther > 0:
            why = f"scores higher than {than}, which was not picked by score"
        elif more > 0:
            why = f"shows more of the {views} than {than}, but is too close to earlier picks"
        elif farther > 0:
            why = f"is farther from earlier picks than {than}, but shows less of the {views}"
        else:
            why = f"shows less of the {views} than {than}, and is closer to earlier picks"
        reasons[int(frame)] = f"{why}; rank {place} of {free.sum()} frames left"
    return reasons


def _left_out(outcome: Outcome, frame: int) -> str:
    """Return why a frame may not be selected."""
    targets = outcome.targets
    if outcome.health is not None and frame in targets.bad:
        return "; ".join(str(f) for f in outcome.health.of(frame) if f.kind != DUPLICATE)
    if frame in targets.frames:
        return "held out as a target"
    return "excluded by never (--never)" if frame in targets.never else "does not show the object"


def reason(budget: Budget) -> str:
    """Return the reason for a number of frames, in words."""
    rule, all_frames = budget.rule, budget.table.total
    bound = f"{rule.loss:g} dB against all {all_frames}, 9 times in 10 (--loss {rule.loss:g})"
    if budget.within is not None and budget.within < budget.enough:
        limit = f"the most that {rule.trainer} fits into {rule.memory:,} bytes"
        return f"{budget.frames} frames, {limit}; {budget.enough} lose at most {bound}"
    if budget.enough == all_frames:
        return f"all {all_frames} frames: fewer may lose more than {rule.loss:g} dB"
    return f"{budget.frames} frames: they lose at most {bound}"


def summary(outcome: Outcome) -> str:
    """Return what was selected and why, in one sentence."""
    tried, targets = outcome.selection.tried, outcome.targets
    said = _by(outcome)
    if tried is not None:
        first = tried.trials[0]
        kept = next(trial for trial in tried.trials if trial.name == tried.kept)
        usual = "the rule" if tried.on_targets else "uniform sampling"
        if kept is not first:
            shown = "these views" if tried.on_targets else "the capture's own frames"
            said = f"by {kept.name}, {kept.gain:.1f} dB better than {usual} on {shown}"
        else:
            said = f"{usual} is kept: {_unreplaced(tried)}"
    bad = () if outcome.health is None else outcome.health.findings
    worst = {f.frame: f.kind for f in bad if f.kind != DUPLICATE and f.frame in targets.bad}
    kinds = Counter(worst.values())
    gone = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
    said += f"; {gone} {'frame was' if len(worst) == 1 else 'frames were'} left out" if gone else ""
    return f"{said[0].upper()}{said[1:]}."


def _by(outcome: Outcome) -> str:
    """Say what picked the frames: a method, and the person who kept some."""
    targets, picks, by = outcome.targets, outcome.selection.indices, f"by {outcome.method.name}"
    frames, kept = counted(len(picks), "frame"), int(np.isin(picks, targets.always).sum())
    if not kept:
        return f"{frames} {by}"
    stated = "of --always" + (" or nearest to dropped ones" if len(targets.dropped) else "")
    return f"{frames}: {kept} {stated}" + (f", {len(picks) - kept} {by}" * (kept < len(picks)))


def _unreplaced(tried: ValidationResult) -> str:
    """Say why no other selection took the place of the first, and what may change that."""
    rule, scored = tried.rule, [trial for trial in tried.trials[1:] if np.isfinite(trial.gain)]
    if not scored:
        return "too few frames are left to compare it on"
    best = max(scored, key=lambda one: (rule.agreed(one), one.gain))
    if best.gain < LEAST_SAID:
        return "none of the other selections tried is better here"
    hints = ["--patience 0 takes it"] if best.name == DEFAULT else []
    if best.gain <= rule.margin:
        why = f"less than the {rule.margin} dB that count"
    elif not rule.agreed(best):
        why = "but not by PSNR and SSIM of both reconstructors"
    else:
        why = "which may be chance"
        hints.append(f"--patience {LONGER * tried.seconds:g}s looks longer")
    hint = f" ({', '.join(hints)})" if hints else ""
    lead = f"{best.name} was ahead by {best.gain:.1f} dB, {why}{hint}"
    return f"no other selection is clearly better; {lead}"


def closeness(outcome: Outcome) -> str:
    """Say how close the picks are to the views."""
    views = "frame" if outcome.targets.kind == ALL else "view"
    shift = f"the image shifts by {outcome.mean_shift[-1]:.0%} on average (parallax and turn)"
    return f"From a {views} to the nearest pick, {shift}"


def trials(tried: ValidationResult) -> str:
    """Describe the validation on the capture's own frames, in words."""
    known = [trial for trial in tried.trials[1:] if np.isfinite(trial.gain)]
    scores = ", ".join(f"{trial.name} {trial.gain:+.2f}" for trial in known) or "none scored"
    cut = ", stopped early" if tried.cut else ""
    if tried.on_targets:
        own = f"the images of {counted(tried.validation, 'target')}"
    else:
        own = f"{tried.validation} of the capture's own frames"
    first = f"{'the rule' if tried.on_targets else 'uniform sampling'} ({tried.trials[0].name})"
    return (
        f"{counted(len(tried.trials), 'selection')} on {own}, {counted(tried.fits, 'fit')}{cut}; "
        f"kept: {tried.kept}. dB over {first}: {scores}"
    )


def _placed(found: dict | None) -> dict | None:
    """Return frames of a video or photos that were placed and not, and the times that were lost."""
    if found is None:
        return None
    keys = ("not_placed", "lost", "still", "other", "jumps", "gps")
    rest = {key: found.get(key) for key in keys}
    return {"frames": found["frames"], "placed": len(found["placed"])} | rest


def _validation(tried: ValidationResult) -> dict:
    """Describe what was tried on the capture's own frames, over the first selection."""
    own = {name: getattr(tried, name) for name in ("kept", "fits", "cut", "on_targets")}
    measured = ("gain", "least", "error", "ssim")
    scores = [
        {"name": trial.name}
        | {name: round(getattr(trial, name), 4) for name in measured}
        | {"validation": trial.validation, "fits": trial.fits}
        for trial in tried.trials
    ]
    return own | {"selections": scores}


def _scorer(method: Method) -> dict | None:
    """Return the scorer's provenance, and the coefficients of a linear rule."""
    if not isinstance(method, ScoringMethod):
        return None
    rule = method.scorer
    coefficients = {"coefficients": rule.coefficients} if isinstance(rule, Linear) else {}
    return coefficients | dict(rule.provenance)
