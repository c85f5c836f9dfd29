"""Write what groups of inputs are worth."""

from typing import TYPE_CHECKING

from fsel.experiments.learning.tables import inputs
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, inputs)
