"""Swap the picks of one scene, and measure them as they go."""

from typing import TYPE_CHECKING

from fsel.experiments.studies.swaps import evaluate_swaps
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_swaps)
