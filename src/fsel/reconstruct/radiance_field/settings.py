"""Settings of the reconstructor `radiance_field`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

from fsel.reconstruct.configured import check_integer

HIGHEST_DEGREE = 2
FINEST = 512  # vertices along an edge: the index of their cube takes 512 MB


@dataclass(frozen=True)
class RadianceSettings:
    """Settings of the optimisation; all are free of the scene.

    Attributes:
        sides: vertices along an edge of the contracted cube, one number a stage, coarse to fine.
        steps: of Adam, one number a stage.
        rays: pixels drawn for one step.
        degree: of the spherical harmonics of colour, 0 to 2.
        seed: of the order of the rays and the places of their samples.
    """

    sides: tuple[int, ...] = (40, 80, 144)
    steps: tuple[int, ...] = (80, 80, 100)
    rays: int = 4096
    degree: int = 1
    seed: int = 0

    def __post_init__(self) -> None:
        for name, least, most in (("sides", 4, FINEST), ("steps", 1, math.inf)):
            if not isinstance(listed := getattr(self, name), list | tuple):
                raise ValueError(f"{name} must be a list of integers, got {listed!r}")
            for value in listed:
                check_integer(f"each of {name}", value, least, most)
            object.__setattr__(self, name, tuple(listed))
        if not len(self.sides) == len(self.steps) > 0:
            raise ValueError(
                f"sides and steps must state as many stages, got {self.sides} and {self.steps}"
            )
        if not all(a < b for a, b in pairwise(self.sides)):
            raise ValueError(f"sides must rise, got {self.sides}")
        for name, most in {"rays": math.inf, "degree": HIGHEST_DEGREE, "seed": math.inf}.items():
            check_integer(name, getattr(self, name), int(name == "rays"), most)
