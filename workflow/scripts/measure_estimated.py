"""Measure every selector on given and on estimated poses."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.pose_trials import measure_estimated
from fsel.selector.policies import POLICIES
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    measure_estimated(
        Path(snakemake.input.given[0]).parent,
        Path(snakemake.input.estimated[0]).parent,
        {name: list(snakemake.input[name]) for name in POLICIES},
        snakemake.output[0],
        **dict(snakemake.params.items()),
        config=digest,
    )
