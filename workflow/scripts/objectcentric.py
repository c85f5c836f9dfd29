"""Write the object-centric table."""

from typing import TYPE_CHECKING

from fsel.experiments.objectcentric import objectcentric
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    measured = [
        dict(zip(("dataset", "scene"), scene, strict=True), path=path)
        for scene, path in zip(snakemake.params.scenes, snakemake.input.measured, strict=True)
    ]
    objectcentric(
        measured,
        snakemake.output.table,
        snakemake.output.numbers,
        datasets=snakemake.params.datasets,
        bootstrap=snakemake.params.bootstrap,
        facts=snakemake.params.facts,
    )
