"""Memory and minutes of jobs: they grow with attempts, frames and pixels."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from fsel.core.files import mapped_array

DECLARED_FRAMES = 10_000  # of a capture, up to which what a rule states suffices
DECLARED_SIDE = 128  # pixels of a reconstruction's long side, likewise

Resource = Callable[..., int]


@dataclass(frozen=True)
class Size:
    """Memory and minutes of a job's first attempt.

    Attributes:
        memory_mb, minutes: of a capture of 10,000 frames, reconstructed at 128 pixels.
        grows: with what they grow besides attempts: `capture`, by frames of the largest one among
            the inputs; `reconstruction`, by its pixels too; or nothing.
    """

    memory_mb: int = 1000
    minutes: int = 10
    grows: str = ""

    def resources(self, long_side: int) -> dict[str, Resource]:
        """`mem_mb` and `runtime` of a rule.

        Args:
            long_side: of the images reconstructed from, in pixels.
        """
        pixels = 1.0
        if self.grows == "reconstruction":
            pixels = max(1.0, (long_side / DECLARED_SIDE) ** 2)
        amounts = {"mem_mb": self.memory_mb, "runtime": self.minutes}
        return {name: self._needed(pixels * amount) for name, amount in amounts.items()}

    def _needed(self, amount: float) -> Resource:
        """An amount of which a job that failed gets twice as much, then three times."""
        if not self.grows:
            return lambda wildcards, attempt: int(amount * attempt)
        return lambda wildcards, input, attempt: int(amount * attempt * captured(input))


def captured(files: Iterable[str]) -> float:
    """Frames of the largest capture that is there, over those that a rule's numbers are for."""
    there = [path for path in files if Path(path).name == "images.npy" and os.path.exists(path)]
    return max([1.0, *(len(mapped_array(path)) / DECLARED_FRAMES for path in there)])
