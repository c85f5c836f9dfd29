"""Measure a variant's selections on one evaluation scene."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.ablation.variants import evaluate_variant
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    evaluate_variant(
        Path(snakemake.input.frames).parent,
        snakemake.input.splits,
        snakemake.input.weights,
        snakemake.output,
        name=snakemake.params.name,
        budgets=snakemake.params.budgets,
        reconstruction=snakemake.params.reconstruction,
        config=digest,
    )
