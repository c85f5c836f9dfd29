"""Gain of picks on frames that are not picked, where the whole capture is to be rendered.

Every second of them scores swaps; the others say afterwards whether the swaps were worth it. Eight
of each are never picked.
"""

from __future__ import annotations

import numpy as np

from fsel.core.subsets import evenly
from fsel.metrics import score_views
from fsel.reconstruct import Reconstructor
from fsel.selection.trials import LEAST_VALIDATION

VALIDATION = 96  # frames at most of each half
LEAST = 2 * LEAST_VALIDATION + 2  # frames that are not picked, so that one of each half may be
METRIC = ("psnr",)


def halves(observed: np.ndarray, picks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frames that are not picked, every second one: those that score swaps, and the others.

    Args:
        observed: (P,) all frames, ascending.
        picks: (K,) the first picks.

    Returns:
        (J,) and (J',) frames, ascending, 96 at most.

    Raises:
        ValueError: for fewer than 18 frames that are not picked.
    """
    free = np.setdiff1d(observed, picks)
    if len(free) < LEAST:
        raise ValueError(
            f"{len(free)} of {len(observed)} frames are not picked, on which swaps are scored and "
            f"confirmed; allowed: {LEAST} or more. Hint: fewer picks, or --targets"
        )
    scoring, others = free[::2], free[1::2]
    return scoring[evenly(len(scoring), VALIDATION)], others[evenly(len(others), VALIDATION)]


class UnpickedGain:
    """Mean gain in PSNR over some first picks, on validation frames that neither holds.

    Args:
        reconstructor: bound to a capture, at the reconstruction size.
        frames: (J,) the validation frames, and (J',) those that confirm swaps, ascending; none of
            the first picks, so that no frame is scored on itself.
        picks: (K,) the first picks.

    Attributes:
        base: (J,) PSNR of each validation frame by the first picks.
    """

    def __init__(
        self,
        reconstructor: Reconstructor,
        frames: tuple[np.ndarray, np.ndarray],
        picks: np.ndarray,
    ) -> None:
        self.frames, self._others = frames
        self._reconstructor = reconstructor
        self._images = np.asarray(reconstructor.capture.images[self.frames])
        self.base = self._psnr(picks, np.arange(len(self.frames)))

    def __call__(self, picks: np.ndarray) -> float:
        """Gain in dB of (K,) distinct picks on the validation frames that are not among them.

        It is -inf where the picks leave fewer than eight frames of a half.
        """
        rows = np.flatnonzero(~np.isin(self.frames, picks))
        if min(len(rows), len(np.setdiff1d(self._others, picks))) < LEAST_VALIDATION:
            return -np.inf
        return float((self._psnr(picks, rows) - self.base[rows]).mean())

    def _psnr(self, picks: np.ndarray, rows: np.ndarray) -> np.ndarray:
        model = self._reconstructor.fit(np.sort(picks))
        rendered = model.render(self._reconstructor.capture.view(self.frames[rows]))
        return score_views(rendered, self._images[rows], metrics=METRIC)[:, 0]
