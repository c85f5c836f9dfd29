"""Read one capture into its canonical form."""

from typing import TYPE_CHECKING

from fsel.stages.ingest import ingest
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, ingest)
