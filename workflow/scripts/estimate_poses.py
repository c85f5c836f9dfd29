"""Estimate one capture's poses from its images."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.estimate_poses import estimate_poses
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, estimate_poses)
