"""Write the tables of estimated and noisy poses."""

from typing import TYPE_CHECKING

from fsel.experiments.poses import of_scenes, poses
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    poses(
        of_scenes(snakemake.params.scenes, snakemake.input.estimated),
        of_scenes(snakemake.params.scenes, snakemake.input.noise),
        snakemake.input.errors,
        snakemake.output.table,
        snakemake.output.numbers,
        budgets=snakemake.params.budgets,
        bootstrap=snakemake.params.bootstrap,
        facts=snakemake.params.facts,
    )
