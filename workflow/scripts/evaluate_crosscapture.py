"""Reconstruct one room with every pass held out in turn."""

from typing import TYPE_CHECKING

from fsel.experiments.crosscapture import evaluate_crosscapture
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_crosscapture)
