"""Reconstruct from what FisherRF picks under every lambda."""

from typing import TYPE_CHECKING

from fsel.experiments.fisher_damping import evaluate_damping
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_damping)
