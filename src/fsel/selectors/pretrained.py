"""Scorers on disk as methods: those that come with the package, and one's own."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from fsel.selectors import greedy, reference_loop
from fsel.selectors.greedy import Prepared
from fsel.selectors.policies import KNOWN, ScoringMethod
from fsel.selectors.scorer import Linear, Scorer

FOLDER = Path(__file__).parent / "weights"
FILES = {
    "fsel": "fsel.json",
    "fsel_rule": "fsel_rule.json",
    "less_is_more": "less_is_more.safetensors",
    "less_is_more_no_appearance": "less_is_more_no_appearance.safetensors",
}
"""Policy -> file in `FOLDER`; `make labels` remakes those of `less_is_more`."""
DEFAULT = "fsel"
NETWORK_COST = 10  # what scoring a row by a network costs in plain NumPy beside a linear rule


@cache
def method(name: str = DEFAULT) -> ScoringMethod:
    """Return a method that comes with the package, by a key of `FILES`."""
    return own(FOLDER / FILES[name], name)


def own(path: str | Path, name: str | None = None) -> ScoringMethod:
    """Return the method of a scorer that the workflow wrote; ValueError for what is no scorer, does
    not say what it was made for, or was made for another policy than `name`."""
    scorer = Scorer.load(path)
    made_for = scorer.provenance.get("policy", "")
    if made_for not in KNOWN or "made by" not in scorer.provenance:
        raise ValueError(
            f"{path}: scorer of the policy {made_for!r}, known: {', '.join(KNOWN)}; `made by` "
            f"{scorer.provenance.get('made by', 'is missing')!r}. Hint: the workflow writes both"
        )
    if name not in (None, made_for):
        raise ValueError(
            f"{path}: made for the policy {made_for!r}, not {name!r}. Hint: leave the method out"
        )
    try:
        return KNOWN[made_for].method(scorer, ranking)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def ranking(prepared: Prepared, scorer: Scorer, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Pick as `fsel.selectors.greedy.greedy`; small pools, and rows after given ones, by NumPy."""
    cost = 1 if isinstance(scorer, Linear) else NETWORK_COST
    small = cost * k * len(prepared.pool) <= reference_loop.LARGEST or len(prepared.given)
    return (reference_loop.greedy if small else greedy.greedy)(prepared, scorer, k)
