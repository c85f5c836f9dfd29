"""Write what learning adds to the untrained sum, or how far training seeds spread."""

from typing import TYPE_CHECKING

from fsel.experiments.comparisons import TABLES
from fsel.stages.job import job, named
from fsel.stages.ksweep import Sweep

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    TABLES[snakemake.rule](
        Sweep(
            named(snakemake.params.problems, snakemake.input.evaluations),
            datasets=snakemake.params.datasets,
            budgets=snakemake.params.budgets,
            bootstrap=snakemake.params.bootstrap,
            facts=snakemake.params.facts,
        ),
        snakemake.output.table,
        snakemake.output.numbers,
    )
