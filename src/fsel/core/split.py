"""Targets H, proxies O, candidates P (paper, section 3.1 and Appendix A.2)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fsel.core.capture import Capture
from fsel.core.files import Columns, chosen, read_columns
from fsel.core.geometry import distances_from_middle, pairwise_distances, pose_distance

STRAY = 10.0  # times the spread of the cameras, beyond which a camera's pose is taken to be wrong


@dataclass(frozen=True)
class Split:
    """A partition of a capture's frames.

    Attributes:
        targets: (H,) int64, ascending.
        proxies: (H,) int64, proxies[i] stands in for targets[i].
        candidates: (P,) int64, ascending.
        region: (R,) int64, the candidates inside the target region, ascending.
    """

    targets: np.ndarray
    proxies: np.ndarray
    candidates: np.ndarray
    region: np.ndarray

    def table(self, names: Sequence[str]) -> dict[str, Any]:
        """Return one row a frame that has a role: frame, name, role, proxy_of (-1 unless a proxy),
        in_region."""
        frames = np.sort(np.concatenate([self.candidates, self.targets, self.proxies]))
        role, proxy_of = np.full(len(names), "candidate", object), np.full(len(names), -1)
        role[self.targets], role[self.proxies] = "target", "proxy"
        proxy_of[self.proxies] = self.targets
        columns = {"name": np.array(names, object), "role": role, "proxy_of": proxy_of}
        table = {name: values[frames] for name, values in columns.items()}
        return {"frame": frames, **table, "in_region": np.isin(frames, self.region)}

    @classmethod
    def from_table(cls, table: Columns) -> Split:
        """Split that `table` wrote down, its rows in any order."""
        table = chosen(table, np.argsort(table["frame"]))
        frame, role = table["frame"], table["role"]
        proxies = frame[role == "proxy"]
        return cls(
            targets=frame[role == "target"],
            proxies=proxies[np.argsort(table["proxy_of"][role == "proxy"])],
            candidates=frame[role == "candidate"],
            region=frame[table["in_region"]],
        )

    @classmethod
    def load(cls, path: str | Path) -> Split:
        """Read a split.parquet."""
        return cls.from_table(read_columns(path))


def splits_in(table: Columns) -> Iterator[tuple[dict[str, int], Split]]:
    """Yield each split of a table after `{"coverage": 25}`, or after `{}` without that column."""
    if "coverage" not in table:
        yield {}, Split.from_table(table)
        return
    levels = np.asarray(table["coverage"])
    for coverage in np.unique(levels).tolist():
        yield {"coverage": coverage}, Split.from_table(chosen(table, levels == coverage))


def evaluation_split(
    capture: Capture, draw: int, seed: int, targets: int = 15, among: np.ndarray | None = None
) -> Split:
    """Draw targets anywhere in the capture, or among (n,) int64 of its frames; ValueError for fewer
    than 3 frames a target, or too few in `among`."""
    rng = np.random.default_rng([seed, 1, draw])
    every = plausible(capture)
    among = every if among is None else np.intersect1d(among, every)
    return partition(capture, _drawn(among, targets, rng, capture), every)


def coverage_split(capture: Capture, coverage: int, seed: int) -> Split:
    """Draw targets from the `coverage` per cent of frames nearest to a random anchor camera: 4, 6,
    9, 12, 15 at 25, 40, 60, 80, 100 per cent (paper, Appendix A.3)."""
    if not 1 <= coverage <= 100:
        raise ValueError(f"coverage must be 1 to 100 per cent, got {coverage}")
    rng = np.random.default_rng([seed, 2, coverage])
    anchor = int(rng.integers(len(capture)))
    gap = pairwise_distances(capture.centers, capture.centers[anchor : anchor + 1])[:, 0]
    count = max(1, round(len(capture) * coverage / 100))
    region = np.intersect1d(np.argsort(gap, kind="stable")[:count], plausible(capture))
    chosen = _drawn(region, max(4, int(0.15 * coverage + 0.5)), rng, capture)
    return partition(capture, chosen, region)


def _drawn(
    region: np.ndarray, count: int, rng: np.random.Generator, capture: Capture
) -> np.ndarray:
    if len(region) < count or len(capture) < 3 * count:
        raise ValueError(
            f"{capture.source}: {len(capture)} frames ({len(region)} that may be targets) are too "
            f"few for {count} targets, as many proxies and a pool; at least {3 * count} frames "
            f"({count} that may be targets) are needed: lower the number of targets"
        )
    return np.sort(rng.choice(region, size=count, replace=False))


def plausible(capture: Capture) -> np.ndarray:
    """Return the frames whose cameras are not `STRAY` times farther out than nearly all others; one
    such pose would decide all features."""
    distance, radius = distances_from_middle(capture.centers)
    return np.flatnonzero(distance <= STRAY * radius)


def partition(capture: Capture, targets: np.ndarray, region: np.ndarray) -> Split:
    """Match one distinct proxy to each of (H,) int64 targets by least summed distance; candidates
    in the (R,) int64 `region` count as inside it, and only `plausible` frames are proxies or
    candidates."""
    from scipy.optimize import linear_sum_assignment  # here: most jobs do without, and it is slow

    rest = np.setdiff1d(plausible(capture), targets)
    centers, axes = capture.centers, capture.axes
    cost = pose_distance(centers[targets], axes[targets], centers[rest], axes[rest])
    proxies = rest[linear_sum_assignment(cost)[1]]
    candidates = np.setdiff1d(rest, proxies)
    return Split(targets, proxies, candidates, np.intersect1d(candidates, region))
