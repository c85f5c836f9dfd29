"""Damaged artefacts, refused before a job starts: Snakemake removes outputs of jobs that fail."""

from __future__ import annotations

from collections.abc import Iterable

from fsel.utils.checksums import damages, remade
from fsel.workflow.refusal import Refusal


def check_artefacts(inputs: Iterable[str], outputs: Iterable[str]) -> None:
    """Refuse inputs of the jobs ahead that are not what was written, unless they are made anew.

    Args:
        inputs, outputs: of all jobs of the run.

    Raises:
        Refusal: naming the files, and what makes them anew.
    """
    damaged = damages(set(inputs) - set(outputs))
    if damaged:
        raise Refusal("\n".join([*damaged.values(), remade(damaged, "the options of this run")]))
