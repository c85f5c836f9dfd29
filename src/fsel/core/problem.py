"""Contract of selection methods: what they are given, and what they must return."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from fsel.core.capture import Capture, Views
from fsel.core.files import Columns, read_columns
from fsel.core.split import Split
from fsel.core.subsets import evenly

MOST_FRAMES = 1000  # that stand for a whole capture: reconstructing takes memory with every frame


@dataclass(frozen=True)
class Problem:
    """One selection problem (paper, section 3.1).

    Attributes:
        capture: the posed sequence; images of targets must not be read from it.
        candidates: (P,) int64 frames of the pool P, ascending.
        proxies: (O,) int64 frames of O, one a target, in the targets' order.
        targets: poses of H, without images.
        descriptors: (N, D) float32 unit appearance descriptors of all frames.
        sharpness: (N,) float64 variance of the Laplacian of all frames.
        focus: (3,) centre of the object that the request is about, which then is every view's
            reference point; None for the whole scene.
        fixed_picks: (g,) int64 frames of the pool that are picked first, whatever they are worth;
            only methods that say so look at it.
        targets_unknown: whether the targets stand for the whole capture, since nobody said what
            will be rendered.
        proxies_free: whether proxies may be picked by methods that pick observed frames, as in the
            paper its baselines may.
        target_depths: (T,) how far what each target looks at is, world units; None where poses
            alone decide.
        seconds: (N,) float64 of frames that were sampled from a video, NaN of others; None without.
        features: (P, 14) float64 static features of the candidates against the proxies, columns as
            `fsel.features.columns.STATIC`; None where a method that reads them computes them. What
            replaces one of the other attributes replaces them.
    """

    capture: Capture
    candidates: np.ndarray
    proxies: np.ndarray
    targets: Views
    descriptors: np.ndarray
    sharpness: np.ndarray
    focus: np.ndarray | None = None
    fixed_picks: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))
    targets_unknown: bool = False
    proxies_free: bool = True
    target_depths: np.ndarray | None = None
    seconds: np.ndarray | None = None
    features: np.ndarray | None = None

    @classmethod
    def of(cls, capture: Capture, split: Split, described: Columns) -> Problem:
        """Return the problem of a split, given `descriptor` and `sharpness` of all frames."""
        return cls(
            capture=capture,
            candidates=split.candidates,
            proxies=split.proxies,
            targets=capture.view(split.targets),
            descriptors=np.stack(list(described["descriptor"])).astype(np.float32),
            sharpness=np.asarray(described["sharpness"], np.float64),
        )

    @classmethod
    def load(cls, folder: str | Path, split: str | Path) -> Problem:
        """Read the problem of a split.parquet and the folder of a described capture."""
        folder = Path(folder)
        described = read_columns(folder / "descriptors.parquet")
        return cls.of(Capture.load(folder), Split.load(split), described)

    @cached_property
    def observed(self) -> np.ndarray:
        """(P + O,) int64 every frame that may be picked, ascending; (P,) without free proxies."""
        if not self.proxies_free:
            return self.candidates
        return np.union1d(self.candidates, self.proxies)

    @property
    def sequence(self) -> np.ndarray:
        """Frames that stand for all: the candidates, 1,000 evenly spread where more are."""
        return self.candidates[evenly(len(self.candidates), MOST_FRAMES)]

    def pool(self, name: str) -> np.ndarray:
        """Return the allowed frames: `candidates` (P) or `observed` (P and O), ascending."""
        return {"candidates": self.candidates, "observed": self.observed}[name]


@dataclass(frozen=True)
class Method:
    """A selection method.

    Attributes:
        name: key in the registry and in every table.
        label: how tables print it (LaTeX).
        pool: `candidates` or `observed`.
        nested: whether select(k) is a prefix of select(k + 1), so that one run serves all budgets.
        select: (problem, k, rng) -> (k,) int64 distinct frames in pick order.
        seeds: how many random seeds its results average over; 1 for a deterministic method.
        reads: which of `appearance`, `sharpness` and `images` it looks at; others are left out.
        tracks: whether it looks at sparse points and the frames that see them.
        begins: whether it begins with the problem's `fixed_picks`.
        aimed: whether it knows the targets, or their proxies.
    """

    name: str
    label: str
    pool: str
    nested: bool
    select: Callable[[Problem, int, np.random.Generator], np.ndarray]
    seeds: int = 1
    reads: tuple[str, ...] = ()
    tracks: bool = False
    begins: bool = False
    aimed: bool = False


def checked_select(
    method: Method, problem: Problem, k: int, rng: np.random.Generator
) -> np.ndarray:
    """Run a method and check that it keeps the contract.

    Returns:
        (k,) int64 distinct members of the method's pool, in pick order.

    Raises:
        ValueError: when k is not between 1 and the size of the pool.
        RuntimeError: when the method breaks its contract.
    """
    pool = problem.pool(method.pool)
    if not 1 <= k <= len(pool):
        raise ValueError(
            f"{method.name}: k must be between 1 and the {len(pool)} frames of its pool, got {k}"
        )
    picks = np.asarray(method.select(problem, k, rng))
    if picks.shape != (k,) or picks.dtype != np.int64 or len(np.unique(picks)) != k:
        raise RuntimeError(f"{method.name} returned {picks!r}, not {k} distinct int64 frames")
    if not np.isin(picks, pool).all():
        raise RuntimeError(f"{method.name} picked outside its pool: {np.setdiff1d(picks, pool)}")
    return picks
