"""Draw what swaps gain against seconds."""

from typing import TYPE_CHECKING

from fsel.experiments.studies.swaps import swaps
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, swaps)
