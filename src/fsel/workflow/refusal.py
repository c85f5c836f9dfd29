"""Refusals of a configuration, in words."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import NoReturn

FAILED = re.compile(r"^ +log: (.+) \(check log", re.M)  # in Snakemake's log, of a job that failed
HEAD = re.compile(r"^\S+ \S+ ERROR fsel: |^[\w.]*(Error|Exception): ")  # of what the job said last
SUBSET = re.compile(r"^[\w.]+\.Unfinished: (.*)")  # what of, before the program's own last lines


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
        super().__init__(_said("\n".join(lines), hint))
        self.lines = lines


def refuse(message: str, hint: str) -> NoReturn:
    """End the run with what is wrong and what helps.

    Raises:
        Refusal: always.
    """
    raise Refusal(_said(message, hint))


def _said(message: str, hint: str) -> str:
    return f"config: {message}\nHint: {hint}"


def failures(logs: Iterable[str]) -> str:
    """Tell what the jobs that failed said last, and where the rest of it stands.

    Args:
        logs: Snakemake's own files of the run.
    """
    said = {}
    told = "".join(Path(log).read_text(encoding="utf-8") for log in logs)
    for path in map(Path, FAILED.findall(told)):
        lines = path.read_text(encoding="utf-8").splitlines() if path.is_file() else []
        if lines and " INFO fsel: done in " not in lines[-1]:  # tried again, and done
            found = [m[1] for m in map(SUBSET.match, lines[:-1]) if m]
            said[path] = ": ".join([*found[-1:], HEAD.sub("", lines[-1])])
    return "\n".join(f"fsel: {text}\n  ({path})" for path, text in said.items())
