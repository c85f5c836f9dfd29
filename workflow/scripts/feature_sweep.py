"""Write the table of tested features."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.ablation.tables import feature_sweep
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, feature_sweep)
