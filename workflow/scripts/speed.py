"""Draw selection time against the PSNR behind the search."""

from typing import TYPE_CHECKING

from fsel.pipeline.timing import speed_figure
from fsel.pipeline.workflow import job, named

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    evaluations = named(
        [*snakemake.params.problems, *snakemake.params.problems],
        [*snakemake.input.evaluations, *snakemake.input.oracles],
    )
    speed_figure(snakemake.input.times, evaluations, snakemake.output, k=snakemake.params.k)
