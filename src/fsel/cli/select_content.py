"""Content of selection.json, its frames aside."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path

import numpy as np

from fsel.captures.lazy import LazyCapture
from fsel.cli.options import OPENING
from fsel.core.problem import Method
from fsel.selection.export import record
from fsel.selection.validation import CandidateScore, ValidationResult
from fsel.selectors.policies import ScoringMethod
from fsel.selectors.scorer import Linear

SETTINGS = (
    *("k", "targets", "method", "weights", "seed", "patience", "cover", "cover_share"),
    *("appearance", "masks", "box", "geometry_only", "keep_bad", "vram", "trainer", "always"),
    *("never", "points", "long_side", "downscale", "undistort", "up"),
)
"""Options that the record repeats, in its order."""


def selection_content(
    args: argparse.Namespace,
    opened: LazyCapture,
    outcome: record.Outcome,
    method: Method,
    seconds: dict[str, float],
) -> dict:
    """Content of selection.json without the entries of the frames.

    Args:
        args: the command line.
        opened: the capture.
        outcome: the selection.
        method: that picked.
        seconds: of each step.
    """
    targets, budget = outcome.targets, outcome.selection.budget
    return {
        "capture": {
            "folder": str(Path(args.capture).resolve()),
            "beside": [str(path.resolve()) for path in args.beside],
            "layout": opened.layout,
            "frames": len(opened.capture),
            "dropped": opened.raw.dropped,
            "placed": _placed(opened.found),
            "opened": {name: getattr(args, name) for name in OPENING},
        },
        "targets": {
            "kind": targets.kind,
            "views": len(targets.views),
            "held_out": [opened.capture.names[i] for i in targets.frames],
            "far": int(targets.far.sum()),
        },
        "settings": _settings(args, method),
        "tried": _tried(outcome.selection.tried),
        "cover": None if outcome.selection.cover is None else asdict(outcome.selection.cover),
        "budget": None if budget is None else asdict(budget) | {"reason": record.reason(budget)},
        "scorer": _scorer(method),
        "versions": record.versions(),
        "seconds": {name: round(value, 4) for name, value in seconds.items()},
    }


def _placed(found: dict | None) -> dict | None:
    """Frames of a video or photos that were placed and not, and the times that were lost."""
    if found is None:
        return None
    rest = {key: found.get(key) for key in ("not_placed", "lost", "still", "repeated")}
    return {"frames": found["frames"], "placed": len(found["placed"])} | rest


def _tried(tried: ValidationResult | None) -> dict | None:
    """Describe what was tried on the capture's own frames, over the first selection."""
    if tried is None:
        return None
    selections = [_trial(trial) for trial in tried.trials]
    own = {name: getattr(tried, name) for name in ("kept", "fits", "cut", "on_targets")}
    return own | {"selections": selections}


def _trial(trial: CandidateScore) -> dict:
    """Describe a selection that was compared with another."""
    scores = {name: _finite(getattr(trial, name)) for name in ("gain", "least", "error", "ssim")}
    return {"name": trial.name, **scores, "validation": trial.validation, "fits": trial.fits}


def _finite(value: float) -> float | None:
    """A number as JSON knows it."""
    return round(value, 4) if np.isfinite(value) else None


def _settings(args: argparse.Namespace, method: Method) -> dict:
    """The options that the command ran with."""
    given = {name: getattr(args, name) for name in SETTINGS}
    told = {name: str(value) if isinstance(value, Path) else value for name, value in given.items()}
    told["method"] = method.name
    if args.weights:
        told["weights"] = str(args.weights.resolve())
    if "appearance" not in method.reads:
        told["appearance"] = None
    return told


def _scorer(method: Method) -> dict | None:
    """Scorer of the selection: provenance, and the coefficients of a linear rule."""
    if not isinstance(method, ScoringMethod):
        return None
    rule = method.scorer
    coefficients = {"coefficients": rule.coefficients} if isinstance(rule, Linear) else {}
    return coefficients | dict(rule.provenance)
