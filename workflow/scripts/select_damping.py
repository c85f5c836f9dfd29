"""Select under every lambda of FisherRF."""

from typing import TYPE_CHECKING

from fsel.experiments.fisher_damping import select_damping
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, select_damping)
