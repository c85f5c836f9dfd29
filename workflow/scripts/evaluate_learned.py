"""Reconstruct one scene from the picks of learned networks."""

from typing import TYPE_CHECKING

from fsel.experiments.learning.picking import evaluate_learned
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_learned)
