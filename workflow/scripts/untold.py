"""Write the table and figure of selections without a request."""

from typing import TYPE_CHECKING

from fsel.experiments.studies.unknown_targets import untold
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, untold)
