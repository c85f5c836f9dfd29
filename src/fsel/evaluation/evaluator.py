"""Evaluation of subsets: reconstruct from one, render, compare."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from fsel.core.capture import Capture, Views
from fsel.core.programs import FINISHED, RANGE, Unfinished
from fsel.core.subsets import subset_key
from fsel.metrics import METRICS, Metrics, checked, score_views
from fsel.reconstruct import Model, Reconstructor, reconstructor_of

logger = logging.getLogger(__name__)


class Measured(NamedTuple):
    """Scores of a subset on the views of an `Evaluator`, and what it cost.

    Attributes:
        scores: (T, M) float64, a row a view, a column a metric of the evaluator; NaN where the
            reconstruction did not finish.
        fit_seconds, render_seconds: of the reconstruction, and of rendering all views.
        primitives, bytes, peak_bytes, device: of the model, see `fsel.reconstruct.Model`.
        outcome: a word of `fsel.core.programs`; empty where it finished.
        log: of what did not finish, the last lines.
    """

    scores: np.ndarray
    fit_seconds: float
    render_seconds: float
    primitives: int
    bytes: int
    peak_bytes: int
    device: str
    outcome: str = FINISHED
    log: str = ""


COSTS = Measured._fields[1:]


@dataclass(frozen=True)
class Evaluator:
    """Scores subsets of one capture on frames of it, reconstructing each distinct subset once.

    Attributes:
        reconstructor: bound to the capture; its caches serve every subset.
        frames: (T,) int64 the frames to render.
        views: their poses.
        truth: (T, h, w, 3) uint8 their images, at the reconstruction size.
        masks: (T, h, w) bool, the pixels that count; None for all.
        metrics: M keys of `fsel.metrics.REGISTERED`, or key -> settings.
        keep: sees each subset and its (T, h, w, 3) float32 renderings, for a page that shows them.
    """

    reconstructor: Reconstructor
    frames: np.ndarray
    views: Views
    truth: np.ndarray
    masks: np.ndarray | None = None
    metrics: Metrics = METRICS
    keep: Callable[[np.ndarray, np.ndarray], None] | None = None
    _known: dict[tuple[int, ...], Measured] = field(default_factory=dict, repr=False)

    @classmethod
    def on_frames(
        cls,
        reconstructor: Reconstructor,
        frames: np.ndarray,
        masked: bool = False,
        metrics: Metrics = METRICS,
    ) -> Evaluator:
        """Score on (T,) frames of the reconstructor's capture, inside its masks alone where
        `masked`; ValueError for `masked` without masks, or an unknown metric."""
        chosen = checked(metrics)
        capture = reconstructor.capture
        truth = np.asarray(capture.images[frames])
        masks = None
        if masked:
            if capture.masks is None:
                raise ValueError(f"{capture.source}: has no masks to compare within")
            masks = np.asarray(capture.masks[frames])
        return cls(reconstructor, frames, capture.view(frames), truth, masks, chosen)

    def measure(self, subset: np.ndarray) -> Measured:
        """Return scores and costs of (K,) distinct frames, in any order; or why there are none."""
        key = subset_key(subset)
        if key not in self._known:
            self._known[key] = self._reconstructed(np.array(key))
        return self._known[key]

    def scores(self, subset: np.ndarray) -> np.ndarray:
        """Return (T, M) metrics, one row a view; raise `Unfinished`, which a search cannot rank."""
        measured = self.measure(subset)
        if measured.outcome:
            raise Unfinished(measured.outcome, f"frames {np.sort(subset).tolist()}", measured.log)
        return measured.scores

    def __call__(self, subset: np.ndarray) -> np.ndarray:
        """Return (M,) metrics averaged over the views; errors as of `scores`."""
        return self.scores(subset).mean(axis=0)

    def _reconstructed(self, subset: np.ndarray) -> Measured:
        try:
            return self._scored(subset, self.reconstructor.fit(subset))
        except Unfinished as end:
            logger.error("frames %s: %s: %s", subset.tolist(), end.outcome, end)
            nothing = np.full((len(self.frames), len(self.metrics)), np.nan)
            return Measured(nothing, np.nan, np.nan, 0, 0, 0, "", end.outcome, end.log)

    def _scored(self, subset: np.ndarray, model: Model) -> Measured:
        started = time.perf_counter()
        rendered = model.render(self.views)
        seconds = time.perf_counter() - started
        if not np.isfinite(rendered).all():
            raise Unfinished(RANGE, "the images have values that are not finite")
        if self.keep is not None:
            self.keep(subset, rendered)
        scores = score_views(rendered, self.truth, self.masks, self.metrics)
        sizes = model.primitives, model.bytes, model.peak_bytes
        return Measured(scores, model.seconds, seconds, *sizes, model.device)


def evaluators(
    reconstruction: Mapping[str, Any], metrics: Metrics = METRICS, masked: bool = False
) -> Callable[..., Evaluator]:
    """Return a function of capture and targets that keeps what it made for the last two, so that
    what subsets, draws and trials of a capture share is made once."""

    @lru_cache(2)
    def bound(capture: Capture) -> Reconstructor:
        return reconstructor_of(capture, reconstruction)

    @lru_cache(2)
    def made(capture: Capture, targets: tuple[int, ...]) -> Evaluator:
        return Evaluator.on_frames(bound(capture), np.array(targets), masked, metrics)

    def of(capture: Capture, targets: np.ndarray) -> Evaluator:
        return made(capture, tuple(targets.tolist()))

    return of
