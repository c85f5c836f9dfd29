"""Reconstruct one validation scene from the picks of every trial of a table."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.ablation.trials import evaluate_trials
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_trials)
