"""A parser whose refusals are short, and name the command or the option that was meant."""

from __future__ import annotations

import argparse
import sys
from typing import Any, NoReturn

from fsel.core.registry import closest


class Parser(argparse.ArgumentParser):
    """A parser of one command, or of all."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings, add_help=False)
        self.add_argument("-h", "--help", action="help", help=argparse.SUPPRESS)
        self._given: list[str] = []

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Parse as usual; what is left over is refused here, by the command that it was given."""
        self._given = sys.argv[1:] if args is None else list(args)
        found, left = super().parse_known_args(args, namespace)
        if left:
            self.error(f"unrecognized arguments: {' '.join(left)}")
        return found, left

    def error(self, message: str) -> NoReturn:
        """Print the usage in a line, and what is wrong, and exit with code 2."""
        placed = [a for a in self._actions if not a.option_strings and a.nargs != "*"]
        places = [str(action.metavar or action.dest.upper()) for action in placed]
        usage = f"usage: {self.prog} {' '.join(places)} [options]; {self.prog} --help lists them"
        near = self._meant()
        hint = f". Did you mean {near}?" if near else ""
        self.exit(2, f"{usage}\n{self.prog}: error: {message}{hint}\n")

    def _meant(self) -> str:
        """Return the command or option most like the first word that is none."""
        words = [word.partition("=")[0] for word in self._given]
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                named = next((word for word in words if not word.startswith("-")), "")
                return "" if named in action.choices else closest(named, action.choices)
        known = [name for action in self._actions for name in action.option_strings]
        long = [word for word in words if word.startswith("--") and word != "--"]
        strange = [word for word in long if not any(name.startswith(word) for name in known)]
        return closest(strange[0], known) if strange else ""
