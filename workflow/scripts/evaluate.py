"""Reconstruct from every selection on one capture."""

from typing import TYPE_CHECKING

from fsel.stages.evaluate import evaluate
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate)
