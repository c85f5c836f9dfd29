"""Embedded captures: places filmed in the manner of eight datasets."""

from fsel.synthesis.families import FAMILY
from fsel.synthesis.record import record

FAMILIES: tuple[str, ...] = tuple(FAMILY)

__all__ = ["FAMILIES", "record"]
