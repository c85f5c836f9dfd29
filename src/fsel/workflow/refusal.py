"""Refusals of a configuration, in words."""

from __future__ import annotations

from typing import NoReturn


class Refusal(SystemExit):
    """A configuration that no job could serve.

    It is no `Exception`, so that Snakemake ends with its message alone: wrapped in an error of an
    input function, it would be printed with a traceback.
    """


class MissingProgram(Refusal):
    """A configuration that could be served where a reconstructor's programs were."""


def refuse(message: str, hint: str, kind: type[Refusal] = Refusal) -> NoReturn:
    """End the run with what is wrong and what helps.

    Raises:
        Refusal: always, of the given kind.
    """
    raise kind(f"config: {message}\nHint: {hint}")
