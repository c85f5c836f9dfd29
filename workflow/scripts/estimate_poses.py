"""Estimate one capture's poses from its images."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.estimate_poses import estimate_poses
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    estimate_poses(
        snakemake.input.capture,
        Path(snakemake.output.given[0]).parent,
        Path(snakemake.output.estimated[0]).parent,
        snakemake.output.errors,
        **dict(snakemake.params.items()),
        config=digest,
    )
