"""Write the sweep of FisherRF's lambda."""

from typing import TYPE_CHECKING

from fsel.experiments.fisher_damping import fisher_damping
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, fisher_damping)
