"""Settings of the reconstructor `radiance_field`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from fsel.reconstruct.configured import check_integer, check_number

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
        density_variation, color_variation: weights of the total variation, taken as the mean over
            vertices, beside the squared error, taken as the mean over rays.
        density_rate, color_rate: first step sizes of Adam.
        visible: least share of any selected pixel that a cell must give to be refined.
        seed: of the order of the rays and the places of their samples.
    """

    sides: tuple[int, ...] = (40, 80, 144)
    steps: tuple[int, ...] = (80, 80, 100)
    rays: int = 4096
    degree: int = 1
    density_variation: float = 0.01
    color_variation: float = 0.01
    density_rate: float = 1.0
    color_rate: float = 0.4
    visible: float = 0.05
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("sides", "steps"):
            object.__setattr__(self, name, _integers(name, getattr(self, name)))
        _expect(
            len(self.sides) == len(self.steps) > 0,
            f"sides and steps must state as many stages, got {self.sides} and {self.steps}",
        )
        _expect(
            min(self.sides) >= 4
            and max(self.sides) <= FINEST
            and all(a < b for a, b in zip(self.sides, self.sides[1:], strict=False)),
            f"sides must rise, from 4 or more to at most {FINEST}, got {self.sides}",
        )
        _expect(min(self.steps) >= 1, f"steps must be 1 or more, got {self.steps}")
        for name, most in {"rays": math.inf, "degree": HIGHEST_DEGREE, "seed": math.inf}.items():
            check_integer(name, getattr(self, name), int(name == "rays"), most)
        for name in ("density_variation", "color_variation"):
            check_number(name, getattr(self, name), "zero or more", lambda v: v >= 0)
        for name in ("density_rate", "color_rate"):
            check_number(name, getattr(self, name), "above zero", lambda v: v > 0)
        check_number("visible", self.visible, "at least 0 and below 1", lambda v: 0 <= v < 1)


def _integers(name: str, value: Any) -> tuple[int, ...]:
    """Return a tuple of integers from a list or a tuple of them."""
    listed = isinstance(value, list | tuple)
    good = listed and all(isinstance(v, int) and not isinstance(v, bool) for v in value)
    _expect(good, f"{name} must be a list of integers, got {value!r}")
    return tuple(value)


def _expect(holds: bool, message: str) -> None:
    if not holds:
        raise ValueError(message)
