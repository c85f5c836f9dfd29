"""Write the table of tested features."""

from typing import TYPE_CHECKING

from fsel.experiments.ablation.tables import feature_sweep
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    cases, scenes = snakemake.params.cases, snakemake.params.scenes
    feature_sweep(
        [(*scene, path) for scene, path in zip(scenes, snakemake.input.measured, strict=True)],
        dict(zip(cases, snakemake.input.trials, strict=True)),
        snakemake.output.table,
        snakemake.output.numbers,
        reference=next(iter(cases)),
        cases=cases,
        bootstrap=snakemake.params.bootstrap,
        facts=snakemake.params.facts,
    )
