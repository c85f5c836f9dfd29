"""Command lines of Snakemake whose target would be taken for an option's value.

The profiles call `check` when Snakemake reads them. Options with values of the form `name=value`,
`--default-resources` among them, are refused by Snakemake itself before it reads a profile:
docs/cluster.md has its words.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence


def _pair(value: str) -> bool:
    return "=" in value


def _config_file(value: str) -> bool:
    return value.endswith((".yaml", ".yml", ".json"))


TAKING = {
    "--config": _pair,
    "-C": _pair,
    "--configfile": _config_file,
    "--configfiles": _config_file,
}
"""Options that take every word that follows -> whether a word is one of theirs."""


def misplaced(arguments: Sequence[str]) -> tuple[str, str] | None:
    """The first option of a command that takes a word which is none of its values, and that word.

    Args:
        arguments: what follows `snakemake`.
    """
    option = ""
    for word in arguments:
        if word == "--":  # only targets follow
            return None
        if word.startswith("-"):
            option = word
        elif option in TAKING and not TAKING[option](word):
            return option, word
    return None


def check() -> None:
    """End this process where a target would be taken for an option's value, saying where to put it.

    Raises:
        SystemExit: naming the option and the target.
    """
    found = misplaced(sys.argv[1:])
    if found:
        option, word = found
        sys.exit(
            f"snakemake: {word!r} stands after {option}, which takes all words that follow it and "
            f"does not know this one.\nHint: put targets first, `snakemake {word} {option} ...`, "
            f"or last, after two hyphens: `... -- {word}`"
        )
