"""Damaged artefacts, refused before a job starts: Snakemake removes outputs of jobs that fail."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from fsel.core.checksums import damages, remade
from fsel.core.wording import counted
from fsel.workflow.refusal import Refusal

NOTES = Path(".snakemake/metadata")  # how files were made, by Snakemake


def check_artefacts(inputs: Iterable[str], outputs: Iterable[str]) -> None:
    """Refuse inputs of the jobs ahead that are not what was written, unless they are made anew.

    Args:
        inputs, outputs: of all jobs of the run.

    Raises:
        Refusal: naming the files, and what makes them anew.
    """
    damaged = damages(set(inputs) - set(outputs))
    if damaged:
        raise Refusal("\n".join([*damaged.values(), remade(damaged)]))


def copies(outputs: Iterable[str]) -> str:
    """Say that outputs which are made again came from another checkout; empty where none did.

    Args:
        outputs: of the jobs ahead.
    """
    there = sorted(path for path in outputs if Path(path).exists())
    if not there or any(NOTES.glob("*")):
        return ""
    return (
        f"config: {counted(len(there), 'result')} of another checkout, as {there[0]}, made again. "
        "Hint: to keep them, end this run, copy them anew, and give the command with --touch once"
    )
