"""Summarise the evaluations into the budget sweep's tables."""

from typing import TYPE_CHECKING

from fsel.stages.ksweep import ksweep
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, ksweep)
