"""Write the comparison of reconstructors."""

from typing import TYPE_CHECKING

from fsel.experiments.reconchoice import reconchoice
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, reconchoice)
