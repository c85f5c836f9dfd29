"""Draw quality, time and memory against the number of frames."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.costs import saturation
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, saturation)
