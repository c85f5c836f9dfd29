"""Measure every selector on poses with noise."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.pose_trials import measure_noise
from fsel.selector.policies import POLICIES
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    measure_noise(
        Path(snakemake.input.frames).parent,
        {name: list(snakemake.input[name]) for name in POLICIES},
        snakemake.output[0],
        **dict(snakemake.params.items()),
        config=digest,
    )
