"""Settings of the reconstructor `gaussians`, and the sizes that `--quality` names."""

from __future__ import annotations

import math
from dataclasses import dataclass

from fsel.core.wording import counted
from fsel.reconstruct.configured import check_integer, check_number

INITIAL = ("splats", "points")
BACKGROUNDS = ("black", "mean")


@dataclass(frozen=True)
class GaussianSettings:
    """Settings of the optimisation; all are free of the scene.

    Attributes:
        steps: of Adam.
        gaussians: the most that a model may have.
        seed: of the order of the views, the relocation, the noise and the dropout.
        degree: of the spherical harmonics, 0 to 2.
        initial: what the Gaussians start from: `splats` (the stereo reconstruction of the selected
            frames) or `points` (sparse points that at least two of them see).
        coarse: share of the steps, the first ones, on images of half the size.
        dropout: share of the Gaussians that the last step leaves out, growing from zero with the
            steps; the others' opacities are raised to make up for it (DropGaussian, Park et al.
            2025).
        background: colour where nothing was reconstructed: `black`, as viewers of the .ply show it,
            or the `mean` of the selected frames' pixels.
    """

    steps: int = 2000
    gaussians: int = 20_000
    seed: int = 0
    degree: int = 2
    initial: str = "splats"
    coarse: float = 0.0
    dropout: float = 0.0
    background: str = "black"

    def __post_init__(self) -> None:
        for name, least in {"steps": 0, "gaussians": 1, "seed": 0, "degree": 0}.items():
            check_integer(name, getattr(self, name), least, 2 if name == "degree" else math.inf)
        check_number("coarse", self.coarse, "between 0 and 1", lambda v: 0 <= v <= 1)
        check_number("dropout", self.dropout, "at least 0 and below 1", lambda v: 0 <= v < 1)
        for name, allowed in {"initial": INITIAL, "background": BACKGROUNDS}.items():
            if getattr(self, name) not in allowed:
                raise ValueError(
                    f"{name} must be one of {', '.join(allowed)}, got {getattr(self, name)!r}"
                )


@dataclass(frozen=True)
class Quality:
    """A size and what it takes, measured with 30 frames."""

    long_side: int  # pixels of the images
    gaussians: int
    steps: int
    step: float  # seconds of a step on one core
    memory: float  # bytes at most

    @property
    def settings(self) -> dict[str, float]:
        """Settings of the reconstructor."""
        return {"steps": self.steps, "gaussians": self.gaussians, "coarse": 0.5}

    def __str__(self) -> str:
        minutes = max(round(self.steps * self.step / 60), 1)
        return (
            f"images of {self.long_side} pixels, {self.gaussians:,} Gaussians, "
            f"{counted(self.steps, 'step')}: about {counted(minutes, 'minute')} of one core, "
            f"{self.memory / 1e9:.1f} GB"
        )


QUALITIES = {
    "draft": Quality(384, 20_000, 1000, 0.034, 0.4e9),
    "good": Quality(640, 60_000, 3000, 0.105, 0.5e9),
    "best": Quality(960, 120_000, 6000, 0.28, 0.7e9),
}
