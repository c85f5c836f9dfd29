"""Reconstruct from every selection on one capture."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.stages.job import job
from fsel.stages.select import evaluate

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    evaluate(
        Path(snakemake.input.frames).parent,
        snakemake.input.splits,
        snakemake.input.selections,
        snakemake.output,
        reconstruction=snakemake.params.reconstruction,
        config=digest,
    )
