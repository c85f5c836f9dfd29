"""Write quality, runtime and memory of the selector and its cheaper variants."""

from typing import TYPE_CHECKING

from fsel.experiments.time_quality import time_quality
from fsel.report.sweep import named
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    problems = snakemake.params.problems
    time_quality(
        named([*problems, *problems], [*snakemake.input.evaluations, *snakemake.input.variant]),
        snakemake.input.costs,
        snakemake.input.times,
        snakemake.output.table,
        snakemake.output.numbers,
        budgets=snakemake.params.budgets,
        bootstrap=snakemake.params.bootstrap,
        facts=snakemake.params.facts,
    )
