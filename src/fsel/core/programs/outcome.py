"""Reasons that keep a program, or a reconstruction, from its results."""

from __future__ import annotations

FAILED = "failed"
TIMEOUT = "timeout"
MEMORY = "out of memory"
MISSING = "no image"
RANGE = "not finite"
FINISHED = ""


class NoDevice(OSError):
    """Error that a program works on a GPU, and there is none here."""


class MissingRequirement(ValueError):
    """Error that a program lacks what it needs; each thing is on a line of the message."""


class Unfinished(RuntimeError):
    """A reconstruction without the images that it was to make.

    Evaluations go on: tables show the outcome in the place of numbers. A search stops, since a
    subset that was not measured cannot be ranked.

    Attributes:
        outcome: one of the words above, but `FINISHED`.
        log: the last lines that the program wrote, if there was one.
    """

    def __init__(self, outcome: str, message: str, log: str = "") -> None:
        super().__init__(f"{message}\n{log}" if log else message)
        self.outcome, self.log = outcome, log or message
