"""Draw the gain over the strongest baseline."""

from typing import TYPE_CHECKING

from fsel.stages.heatmap import heatmap
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, heatmap)
