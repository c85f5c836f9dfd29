"""Measure other coefficients and constants of fsel on a training scene."""

from typing import TYPE_CHECKING

from fsel.experiments.fsel_constants import measure_constants
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, measure_constants)
