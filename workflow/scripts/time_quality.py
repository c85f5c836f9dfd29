"""Write quality, runtime and memory of the selector and its cheaper variants."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.time_quality import time_quality
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, time_quality)
