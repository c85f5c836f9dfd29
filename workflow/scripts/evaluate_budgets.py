"""Reconstruct one evaluation scene from adaptive and fixed numbers of frames."""

from typing import TYPE_CHECKING

from fsel.experiments.studies.budget import evaluate_budgets
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_budgets)
