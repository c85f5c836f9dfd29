"""Write the table of adaptive and fixed budgets."""

from typing import TYPE_CHECKING

from fsel.experiments.studies.budget import budget
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, budget)
