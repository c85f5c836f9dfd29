"""Summarise the evaluations into the budget sweep's tables."""

from typing import TYPE_CHECKING

from fsel.report.sweep import named
from fsel.stages.job import job
from fsel.stages.ksweep import Sweep, ksweep

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    ksweep(
        Sweep(
            named(
                [*snakemake.params.problems, *snakemake.params.oracles],
                [*snakemake.input.evaluations, *snakemake.input.oracles],
            ),
            datasets=snakemake.params.datasets,
            budgets=snakemake.params.budgets,
            bootstrap=snakemake.params.bootstrap,
            facts=snakemake.params.facts,
        ),
        snakemake.output.table,
        snakemake.output.summary,
        snakemake.output.differences,
    )
