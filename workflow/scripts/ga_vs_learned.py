"""Write the selectors beside the search that they imitate."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.ga_vs_learned import ga_vs_learned
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, ga_vs_learned)
