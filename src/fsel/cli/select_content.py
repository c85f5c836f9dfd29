"""Content of selection.json, its frames aside."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path

import numpy as np

from fsel.data.problem import Method
from fsel.export import record
from fsel.ingest.lazy import LazyCapture
from fsel.request.patience import Tried
from fsel.selector.policies import Learned
from fsel.selector.scorer import Linear


def selection_content(
    asked: argparse.Namespace,
    opened: LazyCapture,
    outcome: record.Outcome,
    method: Method,
    seconds: dict[str, float],
) -> dict:
    """Content of selection.json without the entries of the frames.

    Args:
        asked: the command line.
        opened: the capture.
        outcome: the selection.
        method: that picked.
        seconds: of each step.
    """
    targets, budget = outcome.targets, outcome.selection.budget
    swapped = outcome.selection.swapped
    return {
        "capture": {
            "folder": str(Path(asked.capture).resolve()),
            "layout": opened.layout,
            "frames": len(opened.capture),
            "dropped": opened.raw.dropped,
        },
        "targets": {
            "kind": targets.kind,
            "views": len(targets.views),
            "held_out": [opened.capture.names[i] for i in targets.frames],
            "far": int(targets.far.sum()),
        },
        "settings": _settings(asked, method),
        "tried": _tried(outcome.selection.tried),
        "cover": None if outcome.selection.cover is None else asdict(outcome.selection.cover),
        "refined": None
        if swapped is None
        else {
            "gain": round(swapped.gain, 4),
            "tried": swapped.tried,
            "reconstructor": swapped.reconstructor,
        },
        "budget": None if budget is None else asdict(budget) | {"reason": record.reason(budget)},
        "scorer": _scorer(method),
        "versions": record.versions(),
        "seconds": {name: round(value, 4) for name, value in seconds.items()},
    }


def _tried(tried: Tried | None) -> dict | None:
    """What was tried on the capture's own frames, over every n-th frame."""
    if tried is None:
        return None
    selections = [
        {
            "name": trial.name,
            "gain": _finite(trial.gain),
            "error": _finite(trial.error),
            "ssim": _finite(trial.ssim),
            "validation": trial.validation,
            "fits": trial.fits,
        }
        for trial in tried.trials
    ]
    return {"kept": tried.kept, "fits": tried.fits, "cut": tried.cut, "selections": selections}


def _finite(value: float) -> float | None:
    """A number as JSON knows it."""
    return round(value, 4) if np.isfinite(value) else None


def _settings(asked: argparse.Namespace, method: Method) -> dict:
    """The options that the command ran with."""
    return {
        "k": asked.k,
        "targets": asked.targets,
        "method": method.name,
        "weights": str(asked.weights.resolve()) if asked.weights else None,
        "seed": asked.seed,
        "patience": asked.patience,
        "cover": asked.cover,
        "cover_share": asked.cover_share,
        "refine": asked.refine,
        "appearance": asked.appearance if "appearance" in method.reads else None,
        "masks": str(asked.masks) if asked.masks else None,
        "box": asked.box,
        "geometry_only": asked.geometry_only,
        "vram": asked.vram,
        "trainer": asked.trainer,
        "always": str(asked.always) if asked.always else None,
        "never": str(asked.never) if asked.never else None,
        "points": asked.points,
        "long_side": asked.long_side,
        "downscale": asked.downscale,
    }


def _scorer(method: Method) -> dict | None:
    """Scorer of the selection: provenance, and the coefficients of a linear rule."""
    if not isinstance(method, Learned):
        return None
    rule = method.scorer
    coefficients = {"coefficients": rule.coefficients} if isinstance(rule, Linear) else {}
    return coefficients | dict(rule.provenance)
