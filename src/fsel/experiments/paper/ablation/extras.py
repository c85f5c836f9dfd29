"""The six groups of further features that the paper tried (Appendix A.1), three columns each.

A group takes the place of three inputs, so that the scorer keeps its width.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fsel.core.geometry import lengths, pairwise_angles, pairwise_distances
from fsel.core.problem import Problem
from fsel.features.appearance import KERNEL_JITTER
from fsel.features.columns import positions
from fsel.selectors.greedy import Prepared, standardise


@dataclass(frozen=True)
class Relations:
    """Relations of the n frames of a pool to the O proxies, and what compares them to one another.

    Attributes:
        distance: (n, O) of camera centres, world units.
        angle: (n, O) of viewing directions, radians.
        likeness: (n, O) cosines of the descriptors.
        centers, axes: (n, 3) camera centres less their mean, unit optical axes.
        descriptors: (n, D) float64, of unit length or zero.
        frames: of the whole capture.
        budget: frames that will be picked.
    """

    distance: np.ndarray
    angle: np.ndarray
    likeness: np.ndarray
    centers: np.ndarray
    axes: np.ndarray
    descriptors: np.ndarray
    frames: int
    budget: int


def relations(problem: Problem, prepared: Prepared, budget: int) -> Relations:
    """Compute the relations of a prepared selection's pool."""
    views, rows = problem.capture.view(problem.proxies), prepared.rows
    described = problem.descriptors.astype(np.float64)
    own, others = described[prepared.pool], described[problem.proxies]
    return Relations(
        distance=pairwise_distances(problem.capture.centers[prepared.pool], views.centers),
        angle=pairwise_angles(rows.axes, views.axes),
        likeness=np.einsum("nd,od->no", own, others),
        centers=rows.centers,
        axes=rows.axes,
        descriptors=own,
        frames=len(problem.capture),
        budget=budget,
    )


def worst_case(scene: Relations, picked: Sequence[int]) -> np.ndarray:
    """(n, 3) largest distance and angle, and lowest likeness, to any proxy."""
    columns = scene.distance.max(axis=1), scene.angle.max(axis=1), scene.likeness.min(axis=1)
    return np.stack(columns, axis=1)


def capture_context(scene: Relations, picked: Sequence[int]) -> np.ndarray:
    """(n, 3) radius of the pool around its mean, log of its size, K / N: equal in all rows."""
    count = len(scene.centers)
    values = [lengths(scene.centers).max(), np.log(count), scene.budget / scene.frames]
    return np.tile(values, (count, 1))


def rank_normalised(scene: Relations, picked: Sequence[int]) -> np.ndarray:
    """(n, 3) mean ranks of d_min_o, d_mean_o, gamma_mean_o, from -0.5 to 0.5."""
    from scipy.stats import rankdata  # here: every start of the workflow imports this module

    columns = scene.distance.min(axis=1), scene.distance.mean(axis=1), scene.angle.mean(axis=1)
    places = rankdata(np.stack(columns, axis=1), axis=0) - 1
    return places / max(len(places) - 1, 1) - 0.5


def soft_aggregates(scene: Relations, picked: Sequence[int]) -> np.ndarray:
    """(n, 3) soft minima of distance and angle and soft maximum of likeness over the proxies, at
    the temperature of their deviation over all pairs, which the paper does not give."""
    from scipy.special import softmax

    columns = []
    for values, sign in ((scene.distance, -1), (scene.angle, -1), (scene.likeness, 1)):
        temperature = values.std() or 1.0
        columns.append((softmax(sign * values / temperature, axis=1) * values).sum(axis=1))
    return np.stack(columns, axis=1)


def mean_redundancy(scene: Relations, picked: Sequence[int]) -> np.ndarray:
    """(n, 3) mean distance, angle and likeness to all selected frames; zero before the first."""
    if not len(picked):
        return np.zeros((len(scene.centers), 3))
    columns = (
        pairwise_distances(scene.centers, scene.centers[picked]),
        pairwise_angles(scene.axes, scene.axes[picked]),
        np.einsum("nd,sd->ns", scene.descriptors, scene.descriptors[picked]),
    )
    return np.stack([values.mean(axis=1) for values in columns], axis=1)


def set_aware(scene: Relations, picked: Sequence[int]) -> np.ndarray:
    """(n, 3) what a frame would add to the selected ones; zero before the first.

    The share of proxies that it would be the closest selected frame of; the gain of the
    log-determinant of the likenesses (log of its Schur complement); the distance to the
    second-nearest selected frame, zero while there is but one.
    """
    columns = np.zeros((len(scene.centers), 3))
    if not len(picked):
        return columns
    columns[:, 0] = (scene.distance < scene.distance[picked].min(axis=0)).mean(axis=1)
    kernel = np.einsum("nd,sd->sn", scene.descriptors, scene.descriptors[picked])
    among = kernel[:, picked] + KERNEL_JITTER * np.eye(len(picked))
    known = np.einsum("sn,sn->n", kernel, np.linalg.solve(among, kernel))
    own = np.einsum("nd,nd->n", scene.descriptors, scene.descriptors)
    columns[:, 1] = np.log(np.maximum(own + KERNEL_JITTER - known, KERNEL_JITTER))
    if len(picked) > 1:
        gaps = pairwise_distances(scene.centers, scene.centers[picked])
        columns[:, 2] = np.partition(gaps, 1, axis=1)[:, 1]
    return columns


def over_scene(raw: np.ndarray, selectable: np.ndarray) -> np.ndarray:
    """Standardise to z-scores over the whole pool."""
    return standardise(raw)


def over_step(raw: np.ndarray, selectable: np.ndarray) -> np.ndarray:
    """Standardise to z-scores over the rows still selectable; zero in the others."""
    return np.where(selectable[:, None], standardise(raw, selectable), 0.0)


def as_they_are(raw: np.ndarray, selectable: np.ndarray) -> np.ndarray:
    """No z-scores: constant within a scene, or scaled already."""
    return raw


@dataclass(frozen=True)
class Extra:
    """A group of three further features.

    Attributes:
        label: how tables print it.
        raw: (relations, rows picked so far) -> (n, 3) float64.
        scale: (raw values, (n,) bool selectable) -> (n, 3).
        replaces: the features whose inputs it takes.
    """

    label: str
    raw: Callable[[Relations, Sequence[int]], np.ndarray]
    scale: Callable[[np.ndarray, np.ndarray], np.ndarray]
    replaces: tuple[str, str, str] = ("tau_tri", "alpha_mean", "b_perp")

    @property
    def inputs(self) -> list[int]:
        """The three positions among the scorer's inputs."""
        return positions(self.replaces).tolist()


EXTRAS = {
    "worst_case": Extra("worst-case terms", worst_case, over_scene),
    "capture_context": Extra("capture context", capture_context, as_they_are),
    "rank_normalised": Extra(
        "rank-normalized", rank_normalised, as_they_are, ("d_min_o", "d_mean_o", "gamma_mean_o")
    ),
    "soft_aggregates": Extra("soft aggregates", soft_aggregates, over_scene),
    "mean_redundancy": Extra("mean redundancy", mean_redundancy, over_step),
    "set_aware": Extra("set-aware trio", set_aware, over_step),
}
"""Those that take no other's place take that of relative geometry, which the paper's
configurations with a further group leave out."""
