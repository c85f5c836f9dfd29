"""Measure what one training scene gains from ever more frames."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.budget_curves import measure_curves
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    measure_curves(
        Path(snakemake.input.frames).parent,
        snakemake.input.weights,
        snakemake.output[0],
        coverages=snakemake.params.coverages,
        seed=snakemake.params.seed,
        reconstruction=snakemake.params.reconstruction,
        config=digest,
    )
