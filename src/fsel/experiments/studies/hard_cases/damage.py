"""Damaged captures: what selections lose on them, and whether `fsel` stays ahead of k-medoids."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np
from scipy.ndimage import gaussian_filter

from fsel.captures.images.previews import sharpness
from fsel.core.problem import Problem
from fsel.evaluation.methods import METHODS
from fsel.experiments.studies.hard_cases import Case, CaseOutcome, quality, worlds

K, DRAWS = 12, 4
COMPARED = ("fsel", "less_is_more", "kmedoids")
Damage = Callable[[Problem, np.ndarray], Problem]


def survives(damage: Damage, facings: tuple[int, ...] = (-1, 1), kept: bool = False) -> CaseOutcome:
    """Mean PSNR of picks before and after a damage, over cameras on a ring that look at the middle
    (-1) or outward (1), and draws; the damage is given frames that no method picks, `kept` keeps
    the picks."""
    psnr = []
    turn = np.linspace(0, 2 * np.pi, worlds.FRAMES, endpoint=False)
    out = np.column_stack([np.cos(turn), 0 * turn, np.sin(turn)])
    place = out + 0.15 * np.sin(3 * turn)[:, None] * [0.0, 1, 0]
    for facing, draw in product(facings, range(DRAWS)):
        plain = worlds.problem_on(worlds.filmed(place, facing * out), draw=draw)
        picks = _picks(plain)
        hard = damage(plain, np.setdiff1d(plain.candidates, picks))
        pairs = ((plain, picks), (hard, picks if kept else _picks(hard)))
        psnr.append([[quality(p.capture, own, _held(p)) for own in rows] for p, rows in pairs])
    before, after = np.mean(psnr, axis=0)
    lost = before - after
    each = zip(COMPARED, after, lost, strict=True)
    observed = ", ".join(f"{name} {now:.1f} dB (lost {gap:.1f})" for name, now, gap in each)
    error = np.abs(lost).max() if kept else max(after[2] - after[0], 0.0)
    return CaseOutcome(observed, float(error), 0.5 if kept else 0.0, float(lost[0]))


def _picks(problem: Problem) -> list[np.ndarray]:
    return [METHODS[name].select(problem, K, np.random.default_rng(0)) for name in COMPARED]


def _held(problem: Problem) -> np.ndarray:
    return np.setdiff1d(np.arange(len(problem.capture)), problem.observed)


def displaced(problem: Problem, spare: np.ndarray, count: int, radii: float) -> Problem:
    """Move a few cameras away, and make their images a hundred times as sharp."""
    pose, sharp = problem.capture.world_to_camera.copy(), problem.sharpness.copy()
    pose[spare[:count], :, 3] += [0, 0, radii]
    sharp[spare[:count]] *= 100
    capture = replace(problem.capture, world_to_camera=pose)
    return replace(problem, capture=capture, sharpness=sharp)


def blurred(problem: Problem, spare: np.ndarray) -> Problem:
    """Blur every third observed frame."""
    images = np.array(problem.capture.images)
    for frame in problem.observed[::3]:
        images[frame] = gaussian_filter(images[frame].astype(float), (1.5, 1.5, 0))
    capture = replace(problem.capture, images=images)
    return replace(problem, capture=capture, sharpness=sharpness(images))


def zoomed(problem: Problem, spare: np.ndarray) -> Problem:
    """Film every other frame with a focal length half as long again."""
    capture, zoom = problem.capture, np.where(np.arange(worlds.FRAMES) % 2, 1.5, 1.0)
    capture = worlds.filmed(capture.centers, capture.axes, zoom)
    return replace(problem, capture=capture, targets=capture.view(_held(problem)))


AHEAD = "fsel ahead of k-medoids"
MOVED = partial(displaced, count=1, radii=30.0)
CASES = (
    Case("a room filmed outward", AHEAD, lambda: survives(lambda plain, _: plain, (1,))),
    Case("a wrong pose, not picked", "views as before", lambda: survives(MOVED, kept=True)),
    Case("a wrong pose", AHEAD, lambda: survives(MOVED)),
    Case("two cameras far away", AHEAD, lambda: survives(partial(displaced, count=2, radii=5.0))),
    Case("a third of the frames blurred", AHEAD, lambda: survives(blurred)),
    Case("two focal lengths", AHEAD, lambda: survives(zoomed)),
)
