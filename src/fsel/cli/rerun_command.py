"""The command line of a selection, for running it again with frames kept and dropped by hand."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Sequence

from fsel.pages.shown import Commands

LISTS = {"--always": 1, "--never": 1, "--force": 0}
AGAINST = {
    "-k": 1,
    **dict.fromkeys(("--cover", "--cover-share", "--method"), 1),
    **dict.fromkeys(("--vram", "--trainer", "--patience"), 1),
}
"""Options that do not go with frames to keep, and how many values each takes."""


def commands(args: argparse.Namespace, k: int) -> Commands:
    """Return the command lines that a report offers.

    Args:
        args: of `fsel select`.
        k: picks.
    """
    asked = without(args.words, LISTS)
    keeping = [*without(asked, AGAINST), "-k", str(k)]
    again = [["fsel", *words, "--force"] for words in (asked, keeping)]
    view = ["fsel", "view", str(args.out), "-o", f"{args.out}.html"]
    return Commands(*map(shlex.join, (*again, view)))


def without(words: Sequence[str], options: dict[str, int]) -> list[str]:
    """Return a command line without some options and their values; also abbreviated ones."""
    kept, skipped = [], 0
    for word in words:
        if skipped:
            skipped -= 1
            continue
        name, joined, _ = word.partition("=")
        if name.startswith("-k") and "-k" in options:
            name, joined = "-k", word[2:]
        found = next((o for o in options if len(name) > 1 and o.startswith(name)), None)
        if found is None or name == "--":
            kept.append(word)
        elif not joined:
            skipped = options[found]
    return kept
