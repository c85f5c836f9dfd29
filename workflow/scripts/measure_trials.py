"""Reconstruct one validation scene from the picks of every trial of a table."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.ablation.trials import measure_trials
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    measure_trials(
        Path(snakemake.input.frames).parent,
        snakemake.input.splits,
        dict(zip(snakemake.params.names, snakemake.input.trials, strict=True)),
        snakemake.output[0],
        dataset=snakemake.wildcards.dataset,
        scene=snakemake.wildcards.scene,
        reconstruction=snakemake.params.reconstruction,
        config=digest,
    )
