"""The reconstructors that a configuration names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from fsel.workflow.refusal import refuse

Section = Mapping[str, Any]


def named(sections: Section | Sequence[Section], where: str) -> dict[str, Section]:
    """Name -> section of each reconstructor, in order; `as` gives a name of its own.

    Args:
        sections: one, or several.
        where: the key that they stand under.

    Raises:
        Refusal: when two have the same name.
    """
    found: dict[str, Section] = {}
    for section in [sections] if isinstance(sections, Mapping) else sections:
        name = section.get("as", section["name"])
        if name in found:
            refuse(f"{where} has two named {name!r}", "`as` gives one of them another name")
        found[name] = without_name(section)
    return found


def without_name(section: Section) -> Section:
    """A section as reconstructors take it: its cost changes no number, and so no job."""
    return {key: value for key, value in section.items() if key not in ("as", "cost")}


def stated_costs(config: Section) -> list[tuple[Section, Section]]:
    """Reconstructors of a configuration that state what they cost: the section, and its cost.

    Raises:
        Refusal: when one reconstructor states two costs.
    """
    given: list[Section] = []
    for part in (
        config["reconstruction"],
        config["search"]["reconstruction"],
        config["transfer"]["reconstructions"],
        config["reconchoice"]["reconstructions"],
        config["pictures"],
    ):
        given += [part] if isinstance(part, Mapping) else (part or [])
    found: list[tuple[Section, Section]] = []
    for section in given:
        own, cost = without_name(section), section.get("cost")
        known = [other for known, other in found if known == own]
        if cost and known and known[0] != cost:
            refuse(f"{own['name']} states costs {known[0]} and {cost}", "state one of them")
        if cost and not known:
            found.append((own, cost))
    return found


def described(name: str, section: Section) -> dict[str, Any]:
    """Return what a caption says of a reconstructor."""
    own = section["name"]
    return {
        "reconstructor": own if own == name else f"{name} ({own})",
        "long_side": section["long_side"],
    }
