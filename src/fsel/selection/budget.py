"""Number of frames that is enough: what more would gain, predicted, and what memory allows.

The shift of a view is the parallax and the turn between it and a picked frame, in fields of view:
how far the image moves. PSNR is predicted to fall in proportion to the mean shift of the views'
closest, second and third picked frame; by how much was fitted to reconstructions of training scenes
(`tools/fit_budget.py`).
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np

from fsel.core.capture import Capture, Views
from fsel.selection.scene_depth import image_shift, viewing_distance

THRESHOLD = 0.02  # dB a frame; the choice: docs/notebook/2026-11-number-of-frames.md
WHOLE = 30  # views of a whole capture that the number of frames is found by
NEAREST = 3  # picked frames that a view is served by
RECORD = "budget.json"
LEAST = 2  # frames that a reconstruction needs
SPLATS = "splats"
CARD = 0.9  # share of a GPU's memory that is filled; the rest is for its driver, context and gaps


@dataclass(frozen=True)
class Auto:
    """Number of frames chosen automatically: the fewest that suffice, within a memory limit.

    Attributes:
        threshold: dB; picking ends where no further frames are predicted to gain as much each.
        memory: bytes that a reconstruction may take; None for no limit.
        size: (width, height) in pixels of the images that are trained on, for `memory`; None for
            the capture's own.
        trainer: that the memory is for, a key of `fsel.selection.budget.NEEDS`.

    Raises:
        ValueError: for a threshold that is not above zero.

    Example:
        >>> few = fsel.select("captures/garden", fsel.Auto(threshold=0.05), targets="every:8")
    """

    threshold: float = THRESHOLD
    memory: int | None = None
    size: tuple[int, int] | None = None
    trainer: str = SPLATS

    def __post_init__(self) -> None:
        if not 0 < self.threshold < np.inf:
            raise ValueError(
                f"threshold is {self.threshold}; allowed: numbers above 0, in dB a frame. "
                f"Hint: the default is {THRESHOLD}; larger values keep fewer frames"
            )


@dataclass(frozen=True)
class Budget:
    """A number of frames that was found, and why.

    Attributes:
        rule: that it was found by.
        frames: how many.
        enough: the smallest number after which no frames are predicted to gain the threshold each.
        within: the largest number that fit the memory, or None.
        gain: dB that the last frame kept is predicted to gain.
        missing: dB a frame that the best continuation is predicted to gain; 0 where none is left.
    """

    rule: Auto
    frames: int
    enough: int
    within: int | None
    gain: float
    missing: float


def view_shift(capture: Capture, pool: np.ndarray, views: Views) -> np.ndarray:
    """(n, T) `image_shift` between n frames and T views, at the depth that the pool looks at."""
    depth = np.median(viewing_distance(capture.views, capture.points)[pool])
    return image_shift(capture.view(pool), views, float(depth))


def shifts(shift: np.ndarray) -> np.ndarray:
    """(n + 1, 3) mean shift over the views of their closest, second and third picked frame.

    Row k is after k picks, whose (n, T) `view_shift` is in order; what is not there counts as 1.
    """
    closest = np.ones((NEAREST, shift.shape[1]))
    out = np.ones((len(shift) + 1, NEAREST))
    for k, row in enumerate(shift, 1):
        closest = np.sort(np.concatenate([closest, row[None]]), axis=0)[:NEAREST]
        out[k] = closest.mean(axis=1)
    return out


def predicted(mean_shifts: np.ndarray, worth: np.ndarray) -> np.ndarray:
    """(n + 1,) dB gained over no frames at all, of `shifts`, never falling.

    `worth` is (3,) dB that a field of view of the closest, second and third frame is worth.
    """
    return (1 - mean_shifts) @ worth


def enough(quality: np.ndarray, threshold: float) -> int:
    """The smallest number of frames, two or more, from which on no further ones gain as much as the
    threshold, in dB, each, on average; quality is (n + 1,) dB after 0, 1, ... n picks.

    A single frame that gains little does not end the picking where the next ones gain more.
    """
    return LEAST + int(np.argmax((quality - threshold * np.arange(len(quality)))[LEAST:]))


def most(shift: np.ndarray, auto: Auto, worth: np.ndarray) -> int:
    """Number of picks of a pool, by its (n, T) `view_shift`, that suffices to find the budget: with
    more, the whole gain would be below the threshold for each."""
    whole = (1 - np.sort(shift, axis=0)[:NEAREST].mean(axis=1)) @ worth[: len(shift)]
    return min(len(shift), LEAST + int(min(whole / auto.threshold, len(shift))))


def find(shift: np.ndarray, auto: Auto, size: tuple[int, int], worth: np.ndarray) -> Budget:
    """Find how many picks to keep by their (n, T) `view_shift` in order, n from `most`.

    `size` is (width, height) of the capture's images; for `worth` see `predicted`.
    """
    quality = predicted(shifts(shift), worth)
    least = enough(quality, auto.threshold)
    fits = None if auto.memory is None else within(auto.memory, auto.size or size, auto.trainer)
    frames = least if fits is None else min(least, fits)
    ahead = (quality[frames + 1 :] - quality[frames]) / np.arange(1, len(quality) - frames)
    return Budget(
        rule=auto,
        frames=frames,
        enough=least,
        within=fits,
        gain=float(quality[frames] - quality[frames - 1]),
        missing=float(ahead.max(initial=0.0)),
    )


@cache
def shipped_worth() -> np.ndarray:
    """(3,) what `predicted` multiplies, as the package has it; `make weights` remakes it."""
    text = (files("fsel.selectors") / "weights" / RECORD).read_text(encoding="utf-8")
    return np.array(json.loads(text)["worth"])


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
