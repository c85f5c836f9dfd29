"""Write the table of scorers."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.ablation.tables import scorer_arch
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, scorer_arch)
