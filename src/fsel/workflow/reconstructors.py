"""The reconstructors that a configuration names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from fsel.workflow.refusal import Refusal

Section = Mapping[str, Any]


def named(sections: Section | Sequence[Section], where: str) -> dict[str, Section]:
    """Map the name of each reconstructor under the key `where`, its own by `as`, to its section;
    refuse two of one name."""
    found: dict[str, Section] = {}
    for section in [sections] if isinstance(sections, Mapping) else sections:
        name = section.get("as", section["name"])
        if name in found:
            raise Refusal(f"{where} has two named {name!r}", "`as` gives one of them another name")
        found[name] = without_name(section)
    return found


def without_name(section: Section) -> Section:
    """A section as reconstructors take it."""
    return {key: value for key, value in section.items() if key != "as"}


def described(name: str, section: Section) -> dict[str, Any]:
    """Return what a caption says of a reconstructor."""
    own = section["name"]
    return {
        "reconstructor": own if own == name else f"{name} ({own})",
        "long_side": section["long_side"],
    }
