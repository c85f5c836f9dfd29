"""Write the comparison of reconstructors."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.reconchoice import reconchoice
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, reconchoice)
