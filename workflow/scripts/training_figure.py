"""Draw loss and agreement over epochs."""

from typing import TYPE_CHECKING

from fsel.experiments.training_figure import training_figure
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    training_figure(
        snakemake.input.logs,
        snakemake.output.figures,
        snakemake.output.numbers,
        facts=snakemake.params.facts,
    )
