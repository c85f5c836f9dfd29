"""Measure a reconstructor on one scene: few frames, and all."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.reconchoice import evaluate_reconchoice
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_reconchoice)
