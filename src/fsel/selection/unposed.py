"""Frames for reconstructors that take images alone: chosen and ordered without any pose."""

from __future__ import annotations

import numpy as np

from fsel.captures.lazy import LazyCapture
from fsel.captures.quality.examination import examined
from fsel.captures.quality.findings import DUPLICATE, Health, in_words
from fsel.captures.reporter import SILENT, Reporter
from fsel.core.problem import Method, Problem, checked_select
from fsel.core.registry import Registry
from fsel.features.appearance import LAB_HOG, descriptors
from fsel.selectors.baselines import METHODS, PRACTICE, WITHOUT_POSES
from fsel.selectors.baselines.before_poses import farthest

DEFAULT = "best_n"
_HOMES = PRACTICE.homes | METHODS.homes
_NAMES = (*WITHOUT_POSES, "uniform", "sharpest")
POSELESS: Registry[Method] = Registry("method without poses", {n: _HOMES[n] for n in _NAMES})


def select_unposed(
    opened: LazyCapture, k: int, method: Method, reporter: Reporter = SILENT, keep_bad: bool = False
) -> tuple[np.ndarray, Health]:
    """Pick k frames of what `unposed` opened, and return them with the health of all.

    Duplicates are left out, and bad frames as long as k others remain. The first pick is the one
    that the others resemble most, each next one the least like those before it.
    """
    health, names = examined(opened, reporter.bar("health")), opened.capture.names
    if keep_bad:
        health = Health(sharpness=health.sharpness)
    frames = np.setdiff1d(np.arange(len(names)), health.of_kind(DUPLICATE))
    if not 1 <= k <= len(frames):
        said = f"{opened.capture.source}: k is {k}; allowed: 1 to {len(frames)}, frames that differ"
        raise ValueError(f"{said}. Hint: --rate takes more of a video")
    health = health.leaving_out(frames, len(frames) - k)
    for line in in_words(health, names):
        reporter.say(*line)
    pool = np.setdiff1d(frames, health.left_out)
    capture = opened.loaded(np.arange(len(names)), reporter.bar("images"))
    described = descriptors(capture.images, LAB_HOG)
    known = np.nan_to_num(np.zeros(len(names)) if health.sharpness is None else health.sharpness)
    problem = Problem(capture, pool, pool[:0], capture.view(pool[:0]), described, known)
    picks = checked_select(method, problem, k, np.random.default_rng(0))
    return picks[farthest(described[picks], k)], health
