"""Write the cross-capture table."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.crosscapture import crosscapture
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, crosscapture)
