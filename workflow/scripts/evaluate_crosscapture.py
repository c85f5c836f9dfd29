"""Reconstruct one room with every pass held out in turn."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.crosscapture import evaluate_crosscapture
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_crosscapture)
