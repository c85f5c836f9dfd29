"""Compute the raw features of one capture's problems."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.stages.job import job
from fsel.stages.split import features

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    features(
        Path(snakemake.input.frames).parent,
        snakemake.input.splits,
        snakemake.output,
        config=digest,
    )
