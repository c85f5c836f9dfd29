"""Draw a search's population, and labels from above."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.pipeline_figure import pipeline_figure
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    pipeline_figure(
        Path(snakemake.input.frames).parent,
        snakemake.input.splits,
        dict(zip(snakemake.params.coverages, snakemake.input.labels, strict=True)),
        snakemake.input.trajectories,
        snakemake.output.figures,
        snakemake.output.numbers,
        scene=snakemake.params.scene,
        facts=snakemake.params.facts,
    )
