"""Run every method on every problem of one capture."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.stages.job import job
from fsel.stages.select import select

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    select(
        Path(snakemake.input.frames).parent,
        snakemake.input.splits,
        snakemake.input.weights,
        snakemake.output,
        budgets=snakemake.params.budgets,
        seeds=snakemake.params.seeds,
        config=digest,
    )
