"""Write the cross-capture table."""

from typing import TYPE_CHECKING

from fsel.experiments.crosscapture import crosscapture
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, crosscapture)
