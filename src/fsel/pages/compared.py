"""Scores of methods' picks on the held-out frames of one capture, and their differences."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fsel.core.wording import counted
from fsel.evaluation.statistics import Interval, of_places
from fsel.selection.api import ALL_FRAMES

LEAST = 3  # frames of an interval: of two it is thirteen times as wide as their difference

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

    @property
    def rows(self) -> dict[Cell, list[int]]:
        """Frames used and method -> the budgets k of that row; every frame, one row, is last."""
        rows: dict[Cell, list[int]] = {}
        for k, name in self.scores:
            rows.setdefault((self.used[k, name], name), []).append(k)
        return dict(sorted(rows.items(), key=lambda row: row[0][1] == ALL_FRAMES))

    def means(self, cell: Cell) -> list[float]:
        """Mean of each metric, over held-out frames."""
        return self.scores[cell].mean(axis=0).round(5).tolist()

    @property
    def pairs(self) -> list[Cell]:
        """Each k and method that the first one is compared with."""
        return [(k, name) for k, name in self.scores if name != self.methods[0]]

    def interval(self, cell: Cell) -> Interval:
        """Interval of mean PSNR, over held-out frames."""
        return _interval(self.scores[cell][:, 0])

    def ahead(self, k: int, other: str) -> Interval:
        """Interval of the PSNR by which the first method is ahead, over held-out frames."""
        return _interval(self._gaps(k, other))

    def ahead_on_sharp(self, k: int, other: str) -> Interval | None:
        """The same on the frames that are not blurred; None unless some are, and enough are not."""
        if not self.blurred.any() or (~self.blurred).sum() < LEAST:
            return None
        return _interval(self._gaps(k, other)[~self.blurred])

    def _gaps(self, k: int, other: str) -> np.ndarray:
        return self.scores[k, self.methods[0]][:, 0] - self.scores[k, other][:, 0]


def differences(compared: Compared) -> list[dict]:
    """Rows of k, method (the first), than (another), psnr in dB, ci_low, ci_high, n.

    Where some frames are blurred, `sharp` has psnr, ci_low, ci_high and n of those that are not.
    """
    entries = []
    for k, other in compared.pairs:
        sharp = compared.ahead_on_sharp(k, other)
        entry = {"k": k, "method": compared.methods[0], "than": other}
        entry |= _numbers(compared.ahead(k, other))
        entries.append(entry if sharp is None else entry | {"sharp": _numbers(sharp)})
    return entries


def _interval(values: np.ndarray) -> Interval:
    """Interval of a mean without bounds where they would say nothing."""
    found = of_places(values)
    return found if len(values) >= LEAST else found._replace(low=np.nan, high=np.nan)


def _numbers(gap: Interval) -> dict:
    low, high = (None if np.isnan(end) else round(end, 5) for end in (gap.low, gap.high))
    return {"psnr": round(gap.mean, 5), "ci_low": low, "ci_high": high, "n": gap.n}


def verdict(compared: Compared) -> str:
    """A sentence: how often the first method is ahead of another beyond chance, and behind."""
    pairs, first = compared.pairs, compared.methods[0]
    if not pairs:
        return f"{first} is compared with no other method."
    gaps = [compared.ahead(k, other) for k, other in pairs]
    count, frames = len(gaps), counted(gaps[0].n, "held-out frame")
    if gaps[0].n < LEAST:
        ahead = sum(gap.mean > 0 for gap in gaps)
        few = f"over {frames}: too few to tell from chance"
        return f"{first} is ahead in {ahead} of {counted(count, 'comparison')}, {few}."
    said = f"In {counted(count, 'comparison')} {first} is {_counts(gaps)}"
    said += f" (95 % intervals over {frames})"
    sharp = [compared.ahead_on_sharp(k, other) for k, other in pairs]
    kept = [gap for gap in sharp if gap is not None]
    if not kept:
        return f"{said}."
    return f"{said}; over the {kept[0].n} that are not blurred, {_counts(kept)}."


def _counts(gaps: Sequence[Interval]) -> str:
    if len(gaps) == 1:
        side = "ahead" if gaps[0].mean >= 0 else "behind"
        where = "beyond" if gaps[0].excludes_zero else "within"
        return f"{abs(gaps[0].mean):.2f} dB {side}, {where} chance"
    ahead, behind = sum(gap.low > 0 for gap in gaps), sum(gap.high < 0 for gap in gaps)
    return f"ahead beyond chance in {ahead} and behind in {behind}"
