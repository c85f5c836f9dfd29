"""Summarise the evaluations into the budget sweep's tables."""

from typing import TYPE_CHECKING

from fsel.stages.job import run
from fsel.stages.ksweep import ksweep

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, ksweep)
