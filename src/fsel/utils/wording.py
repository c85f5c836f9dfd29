"""Numbers of things in words."""

from __future__ import annotations


def counted(count: int, thing: str) -> str:
    """`1 frame`, `2 frames`: a number and the noun, given in the singular, that follows it."""
    return f"{count} {thing}" if count == 1 else f"{count} {thing}s"
