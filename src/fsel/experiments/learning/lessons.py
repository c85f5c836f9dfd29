"""Labelled requests as lessons, and walks through them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from fsel.capture import Capture
from fsel.experiments.learning.inputs import COLUMNS, State, inputs
from fsel.experiments.learning.pairs import Pairs
from fsel.files import read_table
from fsel.problem import Problem
from fsel.selector.walk import Walk
from fsel.split import Split

Score = Callable[[np.ndarray], np.ndarray]
"""(n, 1 + F) inputs -> (n,) scores."""


class Steps(NamedTuple):
    """A walk, step by step.

    Attributes:
        features: (K, n, 1 + F) float32 inputs before each pick.
        selectable: (K, n) bool, False once a row is picked.
        picks: (K,) int64 rows.
    """

    features: np.ndarray
    selectable: np.ndarray
    picks: np.ndarray


@dataclass(frozen=True)
class Lesson:
    """One labelled request.

    Attributes:
        place: number of the scene among those read, and of the request within it.
        pairs: of its pool.
        k: frames to pick.
        subsets: (m, K) int64 rows of the pool, ascending, the best subset first.
        psnr: (m,) of each, dB.
    """

    place: tuple[int, int]
    pairs: Pairs
    k: int
    subsets: np.ndarray
    psnr: np.ndarray


def lessons(
    folders: Sequence[str | Path], labels: Sequence[str | Path], splits: Sequence[str | Path]
) -> Iterator[Lesson]:
    """The labelled requests of some scenes, in order.

    Args:
        folders: canonical captures with their descriptors.
        labels, splits: what `fsel.stages.label_requests` wrote of each.
    """
    for scene, (folder, own, drawn) in enumerate(zip(folders, labels, splits, strict=True)):
        capture, table = Capture.load(folder), read_table(drawn)
        described = read_table(Path(folder) / "descriptors.parquet")
        for number, part in read_table(own).groupby("request"):
            split = Split.from_table(table[table["request"] == number])
            pairs = Pairs.of(Problem.of(capture, split, described))
            yield _lesson((scene, int(number)), pairs, part.sort_values("rank"))


def _lesson(place: tuple[int, int], pairs: Pairs, rows: pd.DataFrame) -> Lesson:
    frames = np.stack(rows["subset"].to_list())
    subsets = np.searchsorted(pairs.prepared.pool, frames)
    return Lesson(place, pairs, subsets.shape[1], subsets, rows["psnr"].to_numpy(float))


def walked(pairs: Pairs, k: int, score: Score, among: np.ndarray | None = None) -> Steps:
    """Pick k rows, the best-scored one that is left at each step; ties go to the lowest.

    Args:
        pairs: of a problem's pool.
        k: how many.
        score: of the rows at a step.
        among: (m,) rows that may be picked, of which all are where they are fewer than k; any
            without.
    """
    n = len(pairs.prepared.pool)
    walk = Walk(pairs.prepared)
    allowed = np.ones(n, bool) if among is None else np.isin(np.arange(n), among)
    steps = min(k, int(allowed.sum()))
    features = np.empty((steps, n, 1 + len(COLUMNS)), np.float32)
    selectable = np.empty((steps, n), bool)
    for step in range(steps):
        picked = np.array(walk.picked, np.int64)
        features[step] = inputs(pairs, State(picked, walk.selectable, walk.inputs(), k))
        selectable[step] = walk.selectable
        free = walk.selectable & allowed
        walk.add(int(np.argmax(np.where(free, score(features[step]), -np.inf))))
    return Steps(features, selectable, np.array(walk.picked, np.int64))


def by_rule(features: np.ndarray) -> np.ndarray:
    """The rule's score of (n, 1 + F) inputs."""
    return features[:, 0]
