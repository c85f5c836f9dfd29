"""Numbers and types of things in words."""

from __future__ import annotations

from collections.abc import Sequence
from reprlib import repr as shortened


def counted(count: int, thing: str) -> str:
    """Return a number and its noun, given in the singular: `1 frame`, `2 frames`."""
    return f"{count} {thing}" if count == 1 else f"{count} {thing}s"


def in_minutes(seconds: float) -> str:
    """Return a time as a person says it."""
    minutes = seconds / 60
    return f"about {counted(round(minutes), 'minute')}" if minutes >= 1 else "less than a minute"


def listed(names: Sequence[str]) -> str:
    """Return the first names: `a, b, c, ...`."""
    return ", ".join([*names[:3], *(["..."] if len(names) > 3 else [])])


def check_type(name: str, value: object, kinds: type | tuple[type, ...], expected: str) -> None:
    """Refuse an argument of another type than those allowed, which never are bool."""
    if not isinstance(value, kinds) or isinstance(value, bool):
        raise unexpected(name, value, expected)


def unexpected(name: str, value: object, expected: str) -> TypeError:
    """Make the refusal of an argument of a wrong type; `expected` says which, in words."""
    kind = type(value).__name__
    return TypeError(f"{name} is {shortened(value)} ({kind}); expected {expected}")
