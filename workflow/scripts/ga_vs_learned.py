"""Write the selectors beside the search that they imitate."""

from typing import TYPE_CHECKING

from fsel.experiments.ga_vs_learned import ga_vs_learned
from fsel.report.sweep import named
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    problems = snakemake.params.problems
    ga_vs_learned(
        named([*problems, *problems], [*snakemake.input.evaluations, *snakemake.input.oracles]),
        named(problems, snakemake.input.searched),
        snakemake.output.table,
        snakemake.output.numbers,
        k=snakemake.params.k,
        bootstrap=snakemake.params.bootstrap,
        facts=snakemake.params.facts,
    )
