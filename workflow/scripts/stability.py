"""Run every hard case."""

from typing import TYPE_CHECKING

from fsel.experiments.studies.stability import stability
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, stability)
