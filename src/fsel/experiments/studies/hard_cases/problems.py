"""The ordinary world, made hard in one way each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from fsel.core.problem import Problem
from fsel.experiments.studies.hard_cases import worlds

UTM = np.array([5e5, 1e7, 120.0])  # easting, northing, height in metres


def at(centers: np.ndarray, ahead: np.ndarray | None = None) -> Problem:
    """The problem of given centres, axes at random unless given."""
    axes = worlds.cloud(len(centers))[1] if ahead is None else ahead
    return worlds.problem_on(worlds.filmed(centers, axes))


def one_point() -> Problem:
    """Cameras in one place that look everywhere."""
    return at(np.tile([0.3, 1.7, -2.1], (worlds.FRAMES, 1)))


def line() -> Problem:
    """Centres on a line, evenly."""
    return at(np.linspace(0, 1, worlds.FRAMES)[:, None] * [1.0, 2.0, -0.5])


def clusters() -> Problem:
    """Every second camera a million units away."""
    centers, ahead = worlds.cloud()
    centers[::2] += [1e6, 0, 0]
    return at(centers, ahead)


def displaced(shift: np.ndarray, scale: float) -> Problem:
    """The ordinary world, scaled and shifted."""
    return worlds.moved(worlds.world(), np.eye(3), shift, scale)


def parallel(sign: float) -> Problem:
    """Axes along one line to the last bit, in alternating sense for a sign of -1."""
    centers, noise = worlds.cloud()
    axis = np.array([0.48, 0.6, 0.64])
    return at(
        centers, axis * np.where(np.arange(len(centers)) % 2, sign, 1.0)[:, None] + 2e-16 * noise
    )


def proxy_on_candidate() -> Problem:
    problem = worlds.world()
    pose = problem.capture.world_to_camera.copy()
    pose[problem.candidates[3]] = pose[problem.proxies[0]]
    return replace(problem, capture=replace(problem.capture, world_to_camera=pose))


def reference_on_camera() -> Problem:
    """A candidate stands at the reference point of a proxy, to rounding."""
    problem = worlds.world()
    capture, chosen = problem.capture, problem.candidates[5]
    views = capture.view(problem.proxies)
    for _ in range(60):  # the reference points follow the candidates' centroid
        centroid = capture.centers[problem.candidates].mean(axis=0)
        along = (centroid - views.centers) @ views.axes.T
        first = int(np.argmax(np.diag(along)))
        centers = capture.centers.copy()
        centers[chosen] = views.centers[first] + along[first, first] * views.axes[first]
        capture = replace(capture, world_to_camera=worlds.poses(centers, capture.axes))
    return replace(problem, capture=capture)


def dozens() -> Problem:
    """Every third frame of the world, twelve times."""
    centers, ahead = worlds.cloud(5)
    return at(*(np.repeat(part, 12, axis=0) for part in (centers, ahead)))


def nothing_in_common() -> Problem:
    """Cameras on a sphere that all look away from it and are far from each other."""
    ahead = worlds.cloud()[1]
    return at(1000 * ahead, ahead)


def changed(**columns: Callable[[np.ndarray], np.ndarray]) -> Problem:
    """The ordinary problem with other values in some of its fields."""
    problem = worlds.world()
    fields: dict[str, Any] = {name: of(getattr(problem, name)) for name, of in columns.items()}
    return replace(problem, **fields)


def outlier(values: np.ndarray) -> np.ndarray:
    """The values with one candidate's at 1e12."""
    return np.where(np.arange(len(values)) == worlds.world().candidates[7], 1e12, values)
