"""Draw views of one capture, reconstructed from other captures of the place."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.real_world import real_world
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, real_world)
