"""Run every method on every problem of one capture."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.selector.policies import POLICIES
from fsel.stages.job import job
from fsel.stages.select import select

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    select(
        Path(snakemake.input.frames).parent,
        snakemake.input.splits,
        {name: list(snakemake.input[name]) for name in POLICIES},
        snakemake.output,
        budgets=snakemake.params.budgets,
        seeds=snakemake.params.seeds,
        config=digest,
    )
