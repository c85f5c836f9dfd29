"""Measure what selection and reconstruction cost on one evaluation scene."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.ablation.variants import VARIANTS
from fsel.experiments.costs import measure_costs
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    measure_costs(
        Path(snakemake.input.frames).parent,
        snakemake.input.split,
        {name: snakemake.input[name] for name in VARIANTS},
        snakemake.output.costs,
        snakemake.output.times,
        budgets=snakemake.params.budgets,
        appearance=snakemake.params.appearance,
        reconstruction=snakemake.params.reconstruction,
        config=digest,
    )
