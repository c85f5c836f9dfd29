"""Write the cross-capture table."""

from typing import TYPE_CHECKING

from fsel.experiments.crosscapture import crosscapture
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    measured = [
        dict(zip(("dataset", "scene"), room, strict=True), path=path)
        for room, path in zip(snakemake.params.rooms, snakemake.input.measured, strict=True)
    ]
    crosscapture(
        measured,
        snakemake.output.table,
        snakemake.output.numbers,
        budgets=snakemake.params.budgets,
        bootstrap=snakemake.params.bootstrap,
        facts=snakemake.params.facts,
    )
