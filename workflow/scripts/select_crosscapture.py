"""Select with every pass of one room held out in turn."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.crosscapture import select_crosscapture
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, select_crosscapture)
