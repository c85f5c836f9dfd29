"""Write what learning adds to the untrained sum."""

from typing import TYPE_CHECKING

from fsel.experiments.handsign import handsign
from fsel.report.sweep import named
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    handsign(
        named(snakemake.params.problems, snakemake.input.evaluations),
        snakemake.output.table,
        snakemake.output.numbers,
        datasets=snakemake.params.datasets,
        budgets=snakemake.params.budgets,
        bootstrap=snakemake.params.bootstrap,
        facts=snakemake.params.facts,
    )
