"""Draw the gain over the strongest baseline."""

from typing import TYPE_CHECKING

from fsel.stages.job import job
from fsel.stages.ksweep import heatmap

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    heatmap(
        snakemake.input.summary,
        snakemake.input.differences,
        snakemake.output,
        datasets=snakemake.params.datasets,
        budgets=snakemake.params.budgets,
    )
