"""Reconstruct the picks of some methods with another reconstructor."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.transfer import evaluate_transfer
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_transfer)
