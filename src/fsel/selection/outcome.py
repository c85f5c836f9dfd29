"""A selection with what it was made from, and how close its picks are to the target views."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fsel.captures.lazy import of_capture
from fsel.captures.quality.findings import MISPLACED, Health
from fsel.core.capture import Capture
from fsel.core.outputs import staged
from fsel.core.points import SparsePoints
from fsel.core.problem import Method, Problem
from fsel.core.subsets import evenly
from fsel.core.wording import counted, listed
from fsel.selection.budget import Budget
from fsel.selection.scene_depth import image_shift, viewing_distance
from fsel.selection.targets import ALL, MOST_VIEWS, Targets
from fsel.selection.validation import ValidationResult
from fsel.selectors.rollout import RejectionScores, explain_rejections

WELL = 2  # picks that see a point before it is seen well: its depth takes two
WIDE = 3.0  # times the usual gap between picks, from which the output warns
MOST = 3000  # frames in which gaps are looked for, evenly spread
LEAST = 3  # picks that tell which gap is usual


@dataclass(frozen=True, repr=False)
class Selection:
    """Picked frames, best first: the first j are the selection at budget j for nested methods.

    Attributes:
        names: k frame names in pick order.
        indices: (k,) int64 their numbers in the capture.
        scores: (k,) float64 the scorer's value when each was picked; NaN for methods without one.
        seconds: spent selecting, without images and their sharpness.
        capture: that was selected from.
        budget: how k was found.
        tried: what was tried on the capture's own frames, or on the targets' images.
        held_out: (F,) int64 frames that are targets.
    """

    names: tuple[str, ...]
    indices: np.ndarray
    scores: np.ndarray
    seconds: float
    capture: Capture
    budget: Budget | None = None
    tried: ValidationResult | None = None
    held_out: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))

    def __repr__(self) -> str:
        picked = f"{counted(len(self.names), 'frame')}: {listed(self.names)}"
        held_out = f"; {len(self.held_out)} held out" if len(self.held_out) else ""
        return f"Selection({picked}{held_out})"

    def __len__(self) -> int:
        return len(self.names)

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def export(
        self,
        folder: str | Path,
        *,
        link: bool = False,
        long_side: int | None = None,
        force: bool = False,
    ) -> Path:
        """Write the picks as captures that trainers read, and frames.txt, as `fsel select` does.

        Args:
            folder: to write; it appears whole or not at all.
            link: whether images are hard links.
            long_side: pixels that the images are reduced to; None as they are.
            force: whether what an earlier export wrote there is replaced.

        Returns:
            The folder.

        Raises:
            ValueError: for a capture whose image files are not there.
            FileExistsError: for a folder that is there already, or has files of others in it.

        Example:
            >>> chosen = fsel.select("captures/garden", 20, targets="every:8")
            >>> folder = chosen.export("garden20")
        """
        from fsel.selection.export import subset  # here: most selections are not written

        source = of_capture(self.capture)
        if source is None:
            raise ValueError(
                f"{self.capture!r}: has no image files to export. Hint: fsel.select(folder, ...)"
            )
        subset.check_cameras(source.raw, undistort=False)
        form = subset.Form(link=link, long_side=long_side)
        read = {file.parent for file in source.raw.images if isinstance(file, Path)}
        with staged(Path(folder), sorted(read), force) as stage:
            subset.write(stage, source, self.indices, self.held_out, form)
        return Path(folder)


class Gap(NamedTuple):
    """The largest gap between picks: the frame in it that is farthest from all of them."""

    frame: int
    name: str
    shift: float  # to the nearest pick: turn and parallax, in fields of view
    usual: float  # the median over the picks of that of the farthest frame around each

    @property
    def wide(self) -> bool:
        """Check whether it is so much larger than usual that a part of the scene may be missing."""
        return self.shift > WIDE * self.usual

    def __str__(self) -> str:
        return (
            f"the picks leave a gap: {self.name} lies {self.shift:.2f} fields of view from the "
            f"nearest pick, {self.usual:.2f} is usual. Hint: --always {self.name} picks it; where "
            "all frames there are bad, film that part again"
        )


@dataclass(frozen=True)
class Outcome:
    """A selection with what it was made from.

    Attributes:
        capture, targets, selection, problem, method: of the request.
        health: what is wrong with which frames; None where it was not looked for.
        seconds: of each step.
        seen: sparse points that the picks see, whose tracks number the picks in their order.
    """

    capture: Capture
    targets: Targets
    selection: Selection
    problem: Problem
    method: Method
    health: Health | None
    seconds: dict[str, float]
    seen: SparsePoints | None = None

    @cached_property
    def shift(self) -> np.ndarray:
        """(k, T) how far the image moves from each pick to each view, see `image_shift`; at most 1,
        where nothing is left in view."""
        whole, picks = self.targets.kind == ALL, self.capture.view(self.selection.indices)
        views = self.capture.view(self.served) if whole else self.targets.views
        depth = float(np.median(viewing_distance(picks, self.seen)))
        return np.minimum(image_shift(picks, views, depth), 1.0)

    @cached_property
    def mean_shift(self) -> np.ndarray:
        """(k,) mean over the views of their shift to the nearest pick so far, never rising."""
        return np.minimum.accumulate(self.shift, axis=0).mean(axis=1)

    @property
    def sharpness(self) -> np.ndarray | None:
        """(N,) detail of every frame, 0 where it is unknown; None where no image was looked at."""
        if self.health is None or self.health.sharpness is None:
            return None
        return np.nan_to_num(self.health.sharpness)

    @cached_property
    def served(self) -> np.ndarray:
        """(T,) frames that stand for the views where the whole capture is the target."""
        return evenly(len(self.capture), MOST_VIEWS)

    @cached_property
    def standing(self) -> RejectionScores | None:
        """Scores of all frames at the last pick, where a linear rule made the picks."""
        if not np.isfinite(self.selection.scores).any():  # another was kept than the rule's
            return None
        return explain_rejections(self.method, self.problem, self.selection.indices)

    @cached_property
    def sights(self) -> np.ndarray | None:
        """(k,) of each pick the share of the picks' points that it is the first or second to see;
        None without points."""
        if self.seen is None or not len(self.seen.track_point):
            return None
        k = len(self.selection.indices)
        point, pick = np.divmod(np.unique(self.seen.track_point * k + self.seen.track_frame), k)
        known, first, often = np.unique(point, return_index=True, return_counts=True)
        earlier = np.arange(len(point)) - np.repeat(first, often)
        count = np.bincount(pick[earlier < WELL], minlength=k)
        return count / len(known)

    @cached_property
    def gap(self) -> Gap | None:
        """The largest gap between the picks, in what is seen and not in time; None of few, and
        where targets are stated."""
        capture, picks = self.capture, self.selection.indices
        if self.targets.kind != ALL or len(picks) < LEAST:
            return None
        frames = evenly(len(capture), MOST)
        if self.health is not None:
            frames = np.setdiff1d(frames, self.health.of_kind(MISPLACED))
        depth = float(np.median(viewing_distance(capture.views, capture.points)))
        shift = image_shift(capture.view(picks), capture.view(frames), depth)
        around, nearest = np.zeros(len(picks)), shift.min(axis=0)
        np.maximum.at(around, shift.argmin(axis=0), nearest)
        at = int(np.argmax(nearest))
        frame = int(frames[at])
        return Gap(frame, capture.names[frame], float(nearest[at]), float(np.median(around)))
