"""Reconstruct with exact poses and with noisy ones."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.pose_trials import evaluate_noise
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_noise)
