"""Describe the appearance and the sharpness of one capture's frames."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.stages.describe import describe
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    describe(
        Path(snakemake.input.frames).parent,
        snakemake.output[0],
        kind=snakemake.params.kind,
        weights=snakemake.params.weights,
        config=digest,
    )
