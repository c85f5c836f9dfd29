"""Sweep FisherRF's lambda over the first draw of every evaluation scene."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.fisher_damping import fisher_damping
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    named = zip(
        snakemake.params.datasets, snakemake.input.frames, snakemake.input.splits, strict=True
    )
    fisher_damping(
        [
            {"dataset": dataset, "folder": Path(frames).parent, "split": split}
            for dataset, frames, split in named
        ],
        snakemake.output.table,
        snakemake.output.numbers,
        budgets=snakemake.params.budgets,
        reconstruction=snakemake.params.reconstruction,
    )
