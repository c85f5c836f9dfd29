"""Fit what the adaptive budget predicts."""

from typing import TYPE_CHECKING

from fsel.experiments.studies.budget_curves import fit_budget
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, fit_budget)
