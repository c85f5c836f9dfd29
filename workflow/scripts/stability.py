"""Run every hard case."""

from typing import TYPE_CHECKING

from fsel.experiments.stability import stability
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    stability(snakemake.output.table, snakemake.output.numbers)
