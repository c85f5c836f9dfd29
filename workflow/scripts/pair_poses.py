"""Read a scene with two sources of poses."""

from typing import TYPE_CHECKING

from fsel.experiments.pose_sources import pair_poses
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, pair_poses)
