"""Errors of a configuration."""

from __future__ import annotations


class Refusal(SystemExit):
    """A configuration that no job could serve: what is wrong, and what helps.

    It is no `Exception`, so that Snakemake ends with its message alone: wrapped in an error of an
    input function, it would be printed with a traceback.
    """

    def __init__(self, reason: str, hint: str) -> None:
        super().__init__(f"config: {reason}\nHint: {hint}")
        self.reason = reason


class MissingProgram(Refusal):
    """A configuration that could be served where reconstructors' programs were."""
