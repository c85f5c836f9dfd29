"""Measure what one training scene gains from ever more frames."""

from typing import TYPE_CHECKING

from fsel.experiments.budget_curves import evaluate_curves
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_curves)
