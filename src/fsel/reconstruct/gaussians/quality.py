"""Sizes of a model: what a person asks for in a word, and the seconds and memory that it takes."""

from __future__ import annotations

from dataclasses import dataclass

from fsel.core.wording import counted


@dataclass(frozen=True)
class Quality:
    """A size with what it takes, as `benchmarks/gaussians.py presets` measures it with 30 frames.

    Attributes:
        long_side: pixels of the images' longer side.
        gaussians, steps: see `GaussianSettings`.
        step: seconds of a step on one core.
        memory: bytes at most.
    """

    long_side: int
    gaussians: int
    steps: int
    step: float
    memory: float

    @property
    def settings(self) -> dict[str, int]:
        """Settings of the reconstructor."""
        return {"steps": self.steps, "gaussians": self.gaussians}

    def __str__(self) -> str:
        minutes = max(round(self.steps * self.step / 60), 1)
        return (
            f"images of {self.long_side} pixels, {self.gaussians:,} Gaussians, "
            f"{counted(self.steps, 'step')}: about {counted(minutes, 'minute')} of one core, "
            f"{self.memory / 1e9:.1f} GB"
        )


QUALITIES = {
    "draft": Quality(384, 20_000, 1000, 0.04, 0.4e9),
    "good": Quality(640, 60_000, 3000, 0.12, 0.5e9),
    "best": Quality(960, 120_000, 6000, 0.28, 0.7e9),
}
