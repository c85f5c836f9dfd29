"""Write the table of adaptive and fixed budgets."""

from typing import TYPE_CHECKING

from fsel.experiments.budget import budget
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    budget(
        [
            {"dataset": dataset, "scene": scene, "path": path}
            for (dataset, scene), path in zip(
                snakemake.params.scenes, snakemake.input.measured, strict=True
            )
        ],
        snakemake.output.table,
        snakemake.output.numbers,
        datasets=snakemake.params.datasets,
        auto=snakemake.params.auto,
        facts=snakemake.params.facts,
    )
