"""Embedded captures: places filmed in the manner of eight datasets."""

from fsel.synthetic.families import FAMILY
from fsel.synthetic.record import record

FAMILIES: tuple[str, ...] = tuple(FAMILY)

__all__ = ["FAMILIES", "record"]
