"""Reconstruct one evaluation scene from what methods pick without being told of the views."""

from typing import TYPE_CHECKING

from fsel.experiments.studies.unknown_targets import evaluate_untold
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_untold)
