"""Write the table of frozen picks under other reconstructors."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.transfer import transfer
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, transfer)
