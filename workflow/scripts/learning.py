"""Write what ways to learn are worth."""

from typing import TYPE_CHECKING

from fsel.experiments.learning.tables import learning
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, learning)
