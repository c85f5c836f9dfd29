"""Read a scene with two sources of poses."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.pose_sources import pair_poses
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, pair_poses)
