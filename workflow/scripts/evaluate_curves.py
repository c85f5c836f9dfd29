"""Measure what one training scene gains from ever more frames."""

from typing import TYPE_CHECKING

from fsel.experiments.studies.budget_curves import evaluate_curves
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_curves)
