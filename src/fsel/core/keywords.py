"""Settings of a reconstructor from keywords."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

Settings = TypeVar("Settings")


def settings_from(kind: Callable[..., Settings], given: Mapping[str, Any]) -> Settings:
    """The settings, checked.

    Args:
        kind: a dataclass, every field with a default; it refuses values out of range itself.
        given: some of its fields.

    Raises:
        ValueError: for a name that is no field, or a value that the dataclass refuses.
    """
    allowed = list(inspect.signature(kind).parameters)
    for name in given:
        if name not in allowed:
            raise ValueError(f"no setting {name!r}; allowed: {', '.join(allowed)}")
    return kind(**given)
