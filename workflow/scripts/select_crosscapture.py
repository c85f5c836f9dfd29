"""Select with every pass of one room held out in turn."""

from typing import TYPE_CHECKING

from fsel.experiments.crosscapture import select_crosscapture
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, select_crosscapture)
