"""Candidate inputs of a scorer, group by group, as functions of where a walk has come to.

The first column is not learned: the rule's score, standardised, which a network may be added to.
Unscaled, the rule's scores are fifty times as far apart at the first picks as at the last, and what
is added would count for nothing, or for all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from fsel.experiments.learning.pairs import Pairs
from fsel.features.columns import (
    CONDITIONED,
    RELATIONAL,
    SHARPNESS,
    TARGET_GAIN,
    TARGET_GAIN_INPUT,
    positions,
)
from fsel.features.visibility import sights, visibility_gain
from fsel.selector import pretrained
from fsel.selector.greedy import standardise
from fsel.selector.scorer import Scorer

COMPANY = positions(("d_min_s", "gamma_min_s", "phi_nov"))
BRING = 0.1  # of inputs that are not standardised: a unit's part of a deviation


class State(NamedTuple):
    """Where a walk has come to.

    Attributes:
        picked: (t,) int64 rows so far, in order.
        selectable: (n,) bool, the others.
        shown: (n, 19) what `fsel.selector.walk.Walk` shows of them with the policy `fsel`.
        k: frames that will be picked.
    """

    picked: np.ndarray
    selectable: np.ndarray
    shown: np.ndarray
    k: int


Raw = Callable[[Pairs, State], np.ndarray]
"""(pairs, state) -> (n, c) columns before they are standardised."""


class Group(NamedTuple):
    """Inputs that are shown or withheld together.

    Attributes:
        label: how tables print it.
        columns: names.
        raw: see `Raw`.
        standard: whether the columns are standardised over the rows that are left.
    """

    label: str
    columns: tuple[str, ...]
    raw: Raw
    standard: bool = True


def relation(pairs: Pairs, state: State) -> np.ndarray:
    """The paper's relation to the views, which here are the targets themselves."""
    return pairs.static[:, : len(RELATIONAL)]


def sharpness(pairs: Pairs, state: State) -> np.ndarray:
    """The paper's sharpness, among all frames."""
    return pairs.static[:, len(RELATIONAL) :]


def nearest(pairs: Pairs, state: State) -> np.ndarray:
    """The paper's distances and likeness to the nearest pick; zero before the first."""
    if not len(state.picked):
        return np.zeros((len(state.selectable), len(CONDITIONED)))
    least = [part[:, state.picked].min(axis=1) for part in (pairs.distance, pairs.angle)]
    likest = pairs.likeness[:, state.picked].max(axis=1)
    return np.stack([*least, likest, pairs.bearing[:, state.picked].min(axis=1)], axis=1)


def gain(pairs: Pairs, state: State) -> np.ndarray:
    """The rule's target gain."""
    return state.shown[:, [TARGET_GAIN_INPUT]]


def company(pairs: Pairs, state: State) -> np.ndarray:
    """The rule's distances, which count all picks."""
    return state.shown[:, COMPANY]


def sharper(pairs: Pairs, state: State) -> np.ndarray:
    """Sharpness beside that of nearly equal frames."""
    return pairs.sharper[:, None]


def partners(pairs: Pairs, state: State) -> np.ndarray:
    """Baseline and parallax to the picks that a frame would be matched with.

    The score of the best partner, the summed scores of all, the parallax with the nearest pick, and
    how far that is away; zero before the first.
    """
    if not len(state.picked):
        return np.zeros((len(state.selectable), 4))
    support, apart = pairs.support[:, state.picked], pairs.distance[:, state.picked]
    closest = apart.argmin(axis=1)[:, None]
    parallax = np.take_along_axis(pairs.parallax[:, state.picked], closest, axis=1)[:, 0]
    baseline = np.log(np.take_along_axis(apart, closest, axis=1)[:, 0] + 1e-3)
    return np.stack([support.max(axis=1), support.sum(axis=1), parallax, baseline], axis=1)


def single(pairs: Pairs, state: State) -> np.ndarray:
    """The gain of the target that gains most by a frame, and how many it is the closest pick of."""
    close = pairs.prepared.rows.closeness
    picked = close[state.picked]
    most = (close / (1 + picked.sum(axis=0))).max(axis=1)
    return np.stack([most, (close > picked.max(axis=0, initial=0)).mean(axis=1)], axis=1)


def points(pairs: Pairs, state: State) -> np.ndarray:
    """The part of the target gain that is of points which come into view."""
    visible = pairs.prepared.rows.visible
    rates = sights(visible, state.picked)
    return visibility_gain(visible, rates, len(state.selectable))[:, None]


def progress(pairs: Pairs, state: State) -> np.ndarray:
    """How many are picked, of how many, and what is left to gain: the same for all rows."""
    left = state.shown[state.selectable, TARGET_GAIN_INPUT].max(initial=0)
    values = [len(state.picked) / state.k, np.log(state.k), np.log(max(left, 1e-3))]
    return np.tile(np.array(values) * [1, 1 / 4, BRING], (len(state.selectable), 1))


GROUPS: dict[str, Group] = {
    "relation": Group("relation to the targets", RELATIONAL, relation),
    "nearest": Group("distance to the nearest pick", CONDITIONED, nearest),
    "sharpness": Group("sharpness", (SHARPNESS,), sharpness),
    "gain": Group("target gain", (TARGET_GAIN,), gain),
    "company": Group(
        "distances to all picks", ("company_d", "company_gamma", "company_phi"), company
    ),
    "sharper": Group("sharpness among equals", ("sharper",), sharper),
    "partners": Group(
        "baseline and parallax to partners",
        ("best_partner", "partners", "parallax", "baseline"),
        partners,
    ),
    "single": Group("gain of single targets", ("most_gain", "closest"), single),
    "points": Group("points that come into view", ("points",), points),
    "progress": Group("progress", ("picked", "budget", "left"), progress, standard=False),
}
"""The paper's, in the rule's freedom; the rule's; and further ones."""

COLUMNS = tuple(name for group in GROUPS.values() for name in group.columns)


def shown(groups: Iterable[str]) -> np.ndarray:
    """(F,) bool which columns some of the groups have."""
    asked = set(groups)
    return np.array([name in asked for name in GROUPS for _ in GROUPS[name].columns])


def inputs(pairs: Pairs, state: State) -> np.ndarray:
    """(n, 1 + F) float32: the rule's score and all columns; zero in rows that were picked."""
    values = np.concatenate([group.raw(pairs, state) for group in GROUPS.values()], axis=1)
    scaled = np.where(STANDARD, standardise(values, state.selectable), values)
    score = rule().scores(state.shown.astype(np.float64))[:, None]
    both = np.column_stack([standardise(score, state.selectable), scaled])
    both[~state.selectable] = 0
    return both.astype(np.float32)


def rule() -> Scorer:
    """The four coefficients that come with the package."""
    return pretrained.method("fsel").scorer


STANDARD = np.array([group.standard for group in GROUPS.values() for _ in group.columns])
