"""Summarise the evaluations into the budget sweep's tables."""

from typing import TYPE_CHECKING

from fsel.pipeline.tables import ksweep
from fsel.pipeline.workflow import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    named = zip(
        [*snakemake.params.problems, *snakemake.params.oracles],
        [*snakemake.input.evaluations, *snakemake.input.oracles],
        strict=True,
    )
    evaluations = []
    for problem, path in named:
        dataset, scene, draw = problem.split("/")
        evaluations.append({"dataset": dataset, "scene": scene, "draw": draw, "path": path})
    ksweep(
        evaluations,
        snakemake.output.table,
        snakemake.output.summary,
        snakemake.output.differences,
        datasets=snakemake.params.datasets,
        budgets=snakemake.params.budgets,
        bootstrap=snakemake.params.bootstrap,
        facts=snakemake.params.facts,
    )
