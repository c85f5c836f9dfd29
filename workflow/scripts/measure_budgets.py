"""Reconstruct one evaluation scene from adaptive and fixed numbers of frames."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.budget import measure_budgets
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    measure_budgets(
        Path(snakemake.input.frames).parent,
        snakemake.input.splits,
        snakemake.input.weights,
        snakemake.input.record,
        snakemake.output[0],
        budgets=snakemake.params.budgets,
        coverages=snakemake.params.coverages,
        auto=snakemake.params.auto,
        seed=snakemake.params.seed,
        reconstruction=snakemake.params.reconstruction,
        config=digest,
    )
