"""Scores of methods' picks on the held-out frames of one capture, and their differences."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsel.api import ALL_FRAMES
from fsel.report.statistics import Interval, of_places

Cell = tuple[int, str]  # k as it was requested, and the method


@dataclass(frozen=True)
class Compared:
    """Scores of a comparison, and pictures of a few of its frames.

    Attributes:
        source: what was compared, in words.
        how: the reconstructor and the size of the images, in words.
        names: T held-out frames.
        metrics: M names of metrics, PSNR first.
        scores: (T, M) for each k and method, averaged over seeds.
        used: frames that each reconstruction was made from.
        shown: numbers of the held-out frames that have pictures.
        truth: JPEG of each of them.
        renders: for each k and method, JPEG of its first seed's rendering of each of them.
        blurred: (T,) bool, held-out frames that motion blurred: a sharp rendering of them scores
            less than a blurred one.
        shape: width of the pictures over their height.
    """

    source: str
    how: str
    names: tuple[str, ...]
    metrics: tuple[str, ...]
    scores: dict[Cell, np.ndarray]
    used: dict[Cell, int]
    shown: tuple[int, ...]
    truth: list[bytes]
    renders: dict[Cell, list[bytes]]
    blurred: np.ndarray
    shape: float = 1.0

    @property
    def budgets(self) -> list[int]:
        """Budgets k, in order."""
        return list(dict.fromkeys(k for k, _ in self.scores))

    @property
    def methods(self) -> list[str]:
        """Methods in order; the first one is compared with the others."""
        return list(dict.fromkeys(name for _, name in self.scores))

    def called(self, k: int, method: str) -> str:
        """A method in a sentence; every frame, which no k bounds, by their number."""
        return f"all {self.used[k, method]} frames" if method == ALL_FRAMES else method

    def interval(self, cell: Cell) -> Interval:
        """Interval of mean PSNR, over held-out frames."""
        return of_places(self.scores[cell][:, 0])

    def ahead(self, k: int, other: str) -> Interval:
        """Interval of the PSNR by which the first method is ahead, over held-out frames."""
        return of_places(self._gaps(k, other))

    def ahead_on_sharp(self, k: int, other: str) -> Interval | None:
        """The same on the frames that are not blurred; None unless some are, and two are not."""
        if not self.blurred.any() or (~self.blurred).sum() < 2:
            return None
        return of_places(self._gaps(k, other)[~self.blurred])

    def _gaps(self, k: int, other: str) -> np.ndarray:
        return self.scores[k, self.methods[0]][:, 0] - self.scores[k, other][:, 0]


def differences(compared: Compared) -> list[dict]:
    """Rows of k, method (the first), than (another), psnr in dB, ci_low, ci_high, n, verdict.

    Where some frames are blurred, `sharp` has psnr, ci_low, ci_high and n of those that are not.
    """
    first = compared.methods[0]
    entries = []
    for k in compared.budgets:
        for other in compared.methods[1:]:
            gap, sharp = compared.ahead(k, other), compared.ahead_on_sharp(k, other)
            said = verdict(k, first, compared.called(k, other), gap, sharp)
            entry = {"k": k, "method": first, "than": other, **_numbers(gap), "verdict": said}
            if sharp is not None:
                entry["sharp"] = _numbers(sharp)
            entries.append(entry)
    return entries


def _numbers(gap: Interval) -> dict:
    low, high = (None if np.isnan(end) else round(end, 5) for end in (gap.low, gap.high))
    return {"psnr": round(gap.mean, 5), "ci_low": low, "ci_high": high, "n": gap.n}


def verdict(k: int, first: str, other: str, gap: Interval, sharp: Interval | None = None) -> str:
    """A sentence: how far one method is ahead, and whether the interval excludes zero.

    Args:
        k: number of frames.
        first, other: methods.
        gap: PSNR of the first less the other's, over held-out frames.
        sharp: the same over those that are not blurred, which a second sentence is about.
    """
    side = "ahead of" if gap.mean >= 0 else "behind"
    start = f"K = {k}: {first} is {abs(gap.mean):.2f} dB {side} {other}"
    if np.isnan(gap.low):
        return f"{start} on one held-out frame, which says nothing about others."
    said = f"{start}, {_chance(gap, 'held-out frames')}."
    if sharp is None:
        return said
    side = "ahead" if sharp.mean >= 0 else "behind"
    where = _chance(sharp, "that are not blurred")
    return f"{said} Blurred ones left out, it is {abs(sharp.mean):.2f} dB {side}, {where}."


def _chance(gap: Interval, which: str) -> str:
    where = "beyond" if gap.excludes_zero else "within"
    ends = f"{gap.low:+.2f} to {gap.high:+.2f} dB"
    return f"{where} chance (95 % interval over {gap.n} {which}: {ends})"
