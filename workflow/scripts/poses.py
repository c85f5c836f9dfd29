"""Write the tables of estimated and noisy poses, and draw the noise."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.poses import poses
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, poses)
