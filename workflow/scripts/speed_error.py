"""Draw speed against error, and tell its numbers."""

from typing import TYPE_CHECKING

from fsel.experiments.studies.speed_error import speed_error
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, speed_error)
