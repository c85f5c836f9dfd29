"""Number of frames: what fewer than all of them lose, with an interval, and what memory allows.

What K frames lose was measured on real captures with trained Gaussians (`tools/how_many.py`;
docs/results/how_many.md). It hardly depends on how many frames there are, and small
reconstructions of a capture predict it no better. So a capture's loss is taken as one more of those
measured: the quantiles are those of split conformal prediction (Papadopoulos et al. 2002).
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import TypeAlias

import numpy as np

LOSS = 0.5  # dB
BOUND = "bound"
SHARES = {"low": 0.05, "median": 0.5, "high": 0.95, BOUND: 0.9}  # of captures that lose less
RECORD = "how_many.json"
Record: TypeAlias = Mapping[str, Sequence[float]]
"""The calibration: `frames`, numbers K of them; dB lost with each that `SHARES` of captures stay
below, those of more than K frames, but for `BOUND` of all; the share that lose nothing, `better`;
the `time` of training over that with all frames; `total`, the fewest and the most frames of a
capture; and how many times as `wide` the intervals of one with more frames are."""
LEAST = 2  # frames that a reconstruction needs
SPLATS = "splats"
CARD = 0.9  # share of a GPU's memory that is filled; the rest is for its driver, context and gaps


@dataclass(frozen=True)
class Auto:
    """Number of frames chosen automatically: the fewest that lose little, within a memory limit.

    Attributes:
        loss: dB of PSNR against all frames that may be lost, 9 times in 10.
        memory: bytes that a reconstruction may take; None for no limit.
        size: (width, height) in pixels of the images that are trained on, for `memory`; None for
            the capture's own.
        trainer: that the memory is for, a key of `fsel.selection.budget.NEEDS`.

    Raises:
        ValueError: for a loss that is not above zero.

    Example:
        >>> few = fsel.select("captures/garden", fsel.Auto(loss=1), targets="every:8")
    """

    loss: float = LOSS
    memory: int | None = None
    size: tuple[int, int] | None = None
    trainer: str = SPLATS

    def __post_init__(self) -> None:
        if not 0 < self.loss < np.inf:
            raise ValueError(
                f"loss is {self.loss}; allowed: numbers above 0, in dB of PSNR against all frames. "
                f"Hint: the default is {LOSS}; larger values keep fewer frames"
            )


@dataclass(frozen=True)
class Row:
    """A number of frames; PSNR against all frames in dB, the median over captures and the ends of
    its 90 % interval; time of as many training steps over that with all frames; and the share of
    captures in which fewer frames are better."""

    frames: int
    psnr: float
    low: float
    high: float
    time: float
    better: float


@dataclass(frozen=True)
class HowMany:
    """PSNR of fewer frames against all frames of a capture, as predicted before training.

    Attributes:
        total: all frames.
        rows: numbers of frames, ascending.
        unlike: whether it has more frames than any capture that was measured.
    """

    total: int
    rows: tuple[Row, ...]
    unlike: bool

    @classmethod
    def of(cls, total: int) -> HowMany:
        """Return the table of a capture with so many frames."""
        record = shipped()
        frames = np.array(record["frames"])
        low, median, high, _ = -losses(record, frames, total)
        rest = (record["time"], record["better"])
        columns = zip(frames.tolist(), median, high, low, *rest, strict=True)
        rows = tuple(Row(*row) for row in columns if row[0] < total)
        return cls(total, rows, total > max(record["total"]))

    def __str__(self) -> str:
        if not self.rows:
            return f"no number of frames below {self.total} was measured"
        among = f"PSNR against all {self.total}"
        lines = [f"{'frames kept':>14}   {among:26}time   better than all"]
        for row in self.rows:
            interval = f"{row.psnr:+.1f} dB ({row.low:+.1f} to {row.high:+.1f})"
            lines.append(
                f"{row.frames:>14}   {interval:26}{row.time:4.1f}   {row.better:.0%} of captures"
            )
        if self.unlike:
            most = max(shipped()["total"])
            lines.append(f"no capture measured has so many frames: they had up to {most}")
        return "\n".join(lines)


@dataclass(frozen=True)
class Budget:
    """A number of frames that was found, and why.

    Attributes:
        rule: that it was found by.
        frames: how many.
        enough: the smallest number that loses at most `rule.loss`, 9 times in 10.
        within: the largest number that fits the memory, or None.
        table: what other numbers lose.
    """

    rule: Auto
    frames: int
    enough: int
    within: int | None
    table: HowMany


def losses(record: Record, frames: np.ndarray, total: int = 0) -> np.ndarray:
    """Return (4, n) dB of PSNR that so many frames lose against all, by `SHARES`: the ends of the
    90 % interval, the median, and what is not exceeded 9 times in 10; all farther from the median
    where no capture measured has `total` frames."""
    known, at = -1 / np.sqrt(record["frames"]), -1 / np.sqrt(frames)
    found = np.array([np.interp(at, known, record[name]) for name in SHARES])
    wide = record["wide"][0] if total > max(record["total"]) else 1.0
    median = found[list(SHARES).index("median")]
    return median + wide * (found - median)


def enough(record: Record, loss: float, total: int) -> int:
    """Return the smallest number of frames, of those measured and all between, from which on no
    more than so many dB are lost, 9 times in 10; all of them where none is enough."""
    first, last = int(min(record["frames"])), int(max(record["frames"]))
    frames = np.arange(first, last + 1)
    over = np.flatnonzero(losses(record, frames, total)[-1] > loss)
    least = first + int(over.max(initial=-1)) + 1
    return total if least > last else min(least, total)


def find(auto: Auto, total: int, size: tuple[int, int]) -> Budget:
    """Find how many of all frames to keep; `size` is (width, height) of the capture's images."""
    least = enough(shipped(), auto.loss, total)
    fits = None if auto.memory is None else within(auto.memory, auto.size or size, auto.trainer)
    frames = least if fits is None else min(least, fits)
    return Budget(auto, frames, least, fits, HowMany.of(total))


@cache
def shipped() -> Record:
    """Return the calibration in the package; `make how_many` remakes it."""
    text = (files("fsel.selectors") / "weights" / RECORD).read_text(encoding="utf-8")
    record: Record = json.loads(text)
    return record


@dataclass(frozen=True)
class Need:
    """Bytes that a trainer needs at its peak: `fixed`, for each frame, for each pixel of a frame,
    and for each of so many Gaussians a frame. `share` of the memory may be filled."""

    fixed: float = 0
    frame: float = 0
    pixel: float = 0
    gaussians: int = 0
    gaussian: float = 0
    share: float = CARD

    def of(self, frames: int, size: tuple[int, int]) -> float:
        """Bytes of memory that so many frames of (width, height) pixels ask for."""
        return (self.fixed + frames * self.each(size)) / self.share

    def each(self, size: tuple[int, int]) -> float:
        """Bytes for one frame more."""
        width, height = size
        return self.frame + self.pixel * width * height + self.gaussians * self.gaussian


TRAINERS = {
    # gsplat's documentation, "Evaluation": a line through the peaks of seven scenes of Mip-NeRF 360
    # (1.2 to 6.3 million Gaussians) misses them by 0.06 GB at most; most Gaussians a frame: stump
    "gsplat": Need(fixed=0.22e9, gaussians=45_000, gaussian=1776),
    # the same; its images lie on the GPU as bytes (nerfstudio 1.1.5, method_configs.py)
    "splatfacto": Need(fixed=0.22e9, pixel=3, gaussians=45_000, gaussian=1776),
    # NerfBaselines' results: 3,796 MiB with 109 frames of stump, 3,980 MiB with 272 of room
    "nerfacto": Need(fixed=3.86e9, frame=1.2e6),
    # the paper: 4.6 GB at K = 30, 5.9 at 40, 17.8 at 130; its size of images is not stated
    "long-lrm": Need(fixed=0.65e9, frame=0.132e9),
}
NEEDS = {SPLATS: Need(pixel=32, share=1)} | TRAINERS  # position, opacity, depth, colour in float32


def within(memory: float, size: tuple[int, int], trainer: str = SPLATS) -> int:
    """The largest number of frames of (width, height) pixels that fit into bytes of memory.

    Raises:
        ValueError: for an unknown trainer, or when not even two frames fit.
    """
    if trainer not in NEEDS:
        raise ValueError(f"trainer is {trainer!r}; allowed: {', '.join(NEEDS)}")
    need = NEEDS[trainer]
    least = need.of(LEAST, size)
    if memory < least:
        what = f"the splats of {LEAST} frames" if trainer == SPLATS else f"{trainer} of {LEAST}"
        raise ValueError(
            f"memory is {memory} bytes; allowed: {least:.0f} or more, which {what} of "
            f"{size[0]}x{size[1]} may take, the fewest that can be reconstructed. Hint: allow more"
            + (", or reconstruct from smaller images" if need.pixel else "")
        )
    return int((memory * need.share - need.fixed) // need.each(size))
