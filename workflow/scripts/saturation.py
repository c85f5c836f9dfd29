"""Draw quality, time and memory against the number of frames."""

from typing import TYPE_CHECKING

from fsel.experiments.costs import saturation
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    saturation(
        snakemake.input.costs,
        snakemake.output.figures,
        snakemake.output.numbers,
        facts=snakemake.params.facts,
    )
