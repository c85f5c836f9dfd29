"""Errors of a configuration."""

from __future__ import annotations

from typing import NoReturn


class Refusal(SystemExit):
    """A configuration that no job could serve.

    It is no `Exception`, so that Snakemake ends with its message alone: wrapped in an error of an
    input function, it would be printed with a traceback.
    """


class MissingProgram(Refusal):
    """A configuration that could be served where reconstructors' programs were.

    Args:
        lines: what is not here.
        hint: what helps.
    """

    def __init__(self, lines: list[str], hint: str) -> None:
        super().__init__(_message("\n".join(lines), hint))
        self.lines = lines


def refuse(message: str, hint: str) -> NoReturn:
    """End the run with what is wrong and what helps.

    Raises:
        Refusal: always.
    """
    raise Refusal(_message(message, hint))


def _message(text: str, hint: str) -> str:
    return f"config: {text}\nHint: {hint}"
