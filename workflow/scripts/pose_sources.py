"""Write what another source of poses costs."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.pose_sources import pose_sources
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, pose_sources)
