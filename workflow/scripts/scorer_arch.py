"""Write the table of scorers."""

from typing import TYPE_CHECKING

from fsel.experiments.ablation.tables import scorer_arch
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    labels, scenes = snakemake.params.labels, snakemake.params.scenes
    scorer_arch(
        [(*scene, path) for scene, path in zip(scenes, snakemake.input.measured, strict=True)],
        dict(zip(labels, snakemake.input.trials, strict=True)),
        snakemake.output.table,
        snakemake.output.numbers,
        reference="ours",
        labels=labels,
        bootstrap=snakemake.params.bootstrap,
        facts=snakemake.params.facts,
    )
