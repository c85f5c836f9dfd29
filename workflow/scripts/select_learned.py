"""Select frames of one scene by learned networks."""

from typing import TYPE_CHECKING

from fsel.experiments.learning.picking import select_learned
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, select_learned)
