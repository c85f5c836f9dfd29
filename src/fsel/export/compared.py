"""What methods' picks are worth on the held-out frames of one capture, and the differences."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fsel.api import ALL_FRAMES
from fsel.report.statistics import Interval, of_places

Cell = tuple[int, str]  # k as it was asked for, and the method


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

    @property
    def budgets(self) -> list[int]:
        """k, in order."""
        return list(dict.fromkeys(k for k, _ in self.scores))

    @property
    def methods(self) -> list[str]:
        """In order; the first one is compared with the others."""
        return list(dict.fromkeys(name for _, name in self.scores))

    def called(self, k: int, method: str) -> str:
        """A method in a sentence; every frame, which no k bounds, by their number."""
        return f"all {self.used[k, method]} frames" if method == ALL_FRAMES else method

    def interval(self, cell: Cell) -> Interval:
        """Of mean PSNR, over held-out frames."""
        return of_places(self.scores[cell][:, 0])

    def ahead(self, k: int, other: str) -> Interval:
        """Of how much more PSNR the first method has, by held-out frame."""
        first = self.scores[k, self.methods[0]][:, 0]
        return of_places(first - self.scores[k, other][:, 0])


def differences(compared: Compared) -> list[dict]:
    """k, method (the first), than (another), psnr in dB, ci_low, ci_high, n frames, verdict."""
    first = compared.methods[0]
    found = []
    for k in compared.budgets:
        for other in compared.methods[1:]:
            gap = compared.ahead(k, other)
            bounds = [None if np.isnan(end) else round(end, 5) for end in (gap.low, gap.high)]
            found.append(
                {
                    "k": k,
                    "method": first,
                    "than": other,
                    "psnr": round(gap.mean, 5),
                    "ci_low": bounds[0],
                    "ci_high": bounds[1],
                    "n": gap.n,
                    "verdict": verdict(k, first, compared.called(k, other), gap),
                }
            )
    return found


def verdict(k: int, first: str, other: str, gap: Interval) -> str:
    """A sentence: how far one method is ahead, and whether the interval excludes zero.

    Args:
        k: number of frames.
        first, other: methods.
        gap: PSNR of the first less the other's, over held-out frames.
    """
    side = "ahead of" if gap.mean >= 0 else "behind"
    start = f"K = {k}: {first} is {abs(gap.mean):.2f} dB {side} {other}"
    if np.isnan(gap.low):
        return f"{start} on one held-out frame, which says nothing about others."
    beyond = gap.low > 0 or gap.high < 0
    where = "beyond" if beyond else "within"
    return (
        f"{start}, {where} chance (95 % interval over {gap.n} held-out frames: {gap.low:+.2f} to "
        f"{gap.high:+.2f} dB)."
    )
