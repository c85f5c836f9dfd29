"""Write what the coefficients and constants of fsel are worth."""

from typing import TYPE_CHECKING

from fsel.experiments.fsel_constants import fsel_constants
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, fsel_constants)
