"""Reconstruct with exact poses and with noisy ones."""

from typing import TYPE_CHECKING

from fsel.experiments.pose_trials import evaluate_noise
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_noise)
