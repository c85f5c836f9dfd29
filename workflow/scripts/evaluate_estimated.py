"""Reconstruct with given and with estimated poses."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.pose_trials import evaluate_estimated
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_estimated)
