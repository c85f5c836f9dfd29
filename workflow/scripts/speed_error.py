"""Draw speed against error, and tell its numbers."""

from typing import TYPE_CHECKING

from fsel.experiments.speed_error import speed_error
from fsel.report.sweep import named
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    evaluations = named(
        [*snakemake.params.problems, *snakemake.params.problems],
        [*snakemake.input.evaluations, *snakemake.input.oracles],
    )
    speed_error(
        snakemake.input.times,
        snakemake.input.settings,
        evaluations,
        {"oracles": snakemake.input.subsets, "labels": snakemake.input.labels},
        {name: snakemake.output[name] for name in ("table", "numbers", "pdf", "png")},
        k=snakemake.params.k,
    )
