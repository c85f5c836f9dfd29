"""Draw the gain over the strongest baseline."""

from typing import TYPE_CHECKING

from fsel.pipeline.tables import heatmap
from fsel.pipeline.workflow import job

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
