"""The paper's offline stage: search, order, imitate (sections 3.4 and 3.5).

`fsel train` runs it on captures in memory, the workflow's stages label, order and train run its
steps on files.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from fsel.core.capture import Capture
from fsel.core.problem import Problem
from fsel.core.split import COVERAGES, Split, coverage_split, targets_at
from fsel.evaluation.evaluator import Evaluator
from fsel.reconstruct import Reconstructor
from fsel.selectors.policies import Policy
from fsel.training.imitation import Trajectory
from fsel.training.journal import Journal
from fsel.training.labelled import as_seen
from fsel.training.labelling import searched
from fsel.training.ordering import ordered_item
from fsel.training.search import Evaluate, GeneticSettings

TRIED = 3  # evaluations that are timed


@dataclass(frozen=True)
class Labelling:
    """Settings of labelling; defaults are the paper's (Appendix A.2 and A.3).

    Attributes:
        k: frames of a subset.
        coverages: per cent of a capture that targets are drawn from, one labelled problem each.
        search: of the subsets.
        stored, kept: fittest subsets that get a rank, and that are imitated.
        seed: of splits and searches.
    """

    k: int = 20
    coverages: tuple[int, ...] = COVERAGES
    search: GeneticSettings = field(default_factory=GeneticSettings)
    stored: int = 30
    kept: int = 4
    seed: int = 0

    @property
    def frames_needed(self) -> int:
        """Least frames of a capture: targets, as many proxies, and a subset."""
        return 2 * targets_at(max(self.coverages)) + self.k

    @property
    def evaluations(self) -> int:
        """The most reconstructions that one problem takes."""
        search = self.search
        return search.population + search.generations * (search.population - search.elites)

    def settings(self) -> dict[str, Any]:
        """Return all of it, flat, as the searches read it."""
        flat = asdict(self)
        return {"labeller": "genetic", **flat.pop("search"), **flat}


@dataclass(frozen=True)
class Described:
    """A capture with what selection reads of its images.

    Attributes:
        name: for messages.
        capture: the capture, whose images descriptors were made from.
        descriptors, sharpness: (N, D) and (N,) of all frames.
        reconstructor: bound to it.
    """

    name: str
    capture: Capture
    descriptors: np.ndarray
    sharpness: np.ndarray
    reconstructor: Reconstructor

    def digest(self) -> str:
        """Digest of all that its labels depend on but the settings."""
        capture, total = self.capture, hashlib.sha256("/".join(self.capture.names).encode())
        for array in (
            capture.world_to_camera,
            capture.intrinsics,
            self.descriptors,
            self.sharpness,
        ):
            total.update(np.ascontiguousarray(array).tobytes())
        return total.hexdigest()[:12]


@dataclass(frozen=True)
class Task:
    """One problem to label: a capture at a coverage level."""

    described: Described
    coverage: int
    split: Split

    @property
    def problem(self) -> Problem:
        """Problem as selection sees it."""
        seen, split = self.described, self.split
        views = seen.capture.view(split.targets)
        return Problem(
            *(seen.capture, split.candidates, split.proxies, views),
            descriptors=seen.descriptors,
            sharpness=seen.sharpness,
        )

    @property
    def evaluate(self) -> Evaluate:
        """Evaluation by PSNR, SSIM and GMSD of a subset's reconstruction on the proxies."""
        return Evaluator.on_frames(self.described.reconstructor, self.split.proxies)


def tasks(captures: Sequence[Described], labelling: Labelling) -> list[Task]:
    """Every capture at every coverage level.

    Raises:
        ValueError: for a capture with too few frames.
    """
    return [
        Task(described, coverage, coverage_split(described.capture, coverage, labelling.seed))
        for described in captures
        for coverage in labelling.coverages
    ]


def seconds_needed(task: Task, labelling: Labelling) -> float:
    """Predict the time of one problem: what a few evaluations take, times their number.

    It takes less where subsets share work.

    The first evaluation, which compiles, does not count.
    """
    rng = np.random.default_rng(0)
    evaluate, spent = task.evaluate, []
    for _ in range(TRIED + 1):
        subset = np.sort(rng.choice(task.split.candidates, labelling.k, replace=False))
        started = time.perf_counter()
        evaluate(subset)
        spent.append(time.perf_counter() - started)
    return float(np.mean(spent[1:])) * labelling.evaluations


def label(
    task: Task, labelling: Labelling, policy: Policy, journal: Journal
) -> Iterator[Trajectory]:
    """Search one problem's subsets, order the fittest, and follow them as the policy sees them.

    Args:
        task: see `tasks`.
        labelling: how.
        policy: that will be trained.
        journal: remembers every evaluation.
    """
    problem, seeds = task.problem, [labelling.seed, task.coverage]
    evaluate = journal.remember(f"{task.described.name}/p{task.coverage}", task.evaluate)
    labels = searched(evaluate, problem, task.split, labelling.settings(), seeds)
    return as_seen(problem, ordered_item(problem, labels, labelling.kept), policy)
