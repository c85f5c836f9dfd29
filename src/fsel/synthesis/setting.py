"""Setting of a family: its places, its way of filming, and what its cameras keep clear of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fsel.synthesis.shot import Shot
from fsel.synthesis.solids import Scene


@dataclass(frozen=True)
class Setting:
    """Manner of a family: scene and shot makers, and what its cameras must keep clear of.

    Attributes:
        scene: makes a place.
        shot: plans a filming of so many frames.
        clearance: least distance from a camera to any surface, metres.
        view: least distance straight ahead, metres.
        seeing: least share of the frames that must see the scene's subject, if it has one.
    """

    scene: Callable[[np.random.Generator], Scene]
    shot: Callable[[np.random.Generator, int], Shot]
    clearance: float
    view: float
    seeing: float = 0.0
