"""Measure what modelling only what a scene needs removes and costs."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.economy import economy
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    listed = zip(
        snakemake.input.frames, snakemake.input.splits, snakemake.params.generated, strict=True
    )
    economy(
        [
            {"folder": Path(frames).parent, "split": split, "generated": generated}
            for frames, split, generated in listed
        ],
        snakemake.output.table,
        snakemake.output.numbers,
        k=snakemake.params.k,
        reconstruction=snakemake.params.reconstruction,
        appearance=snakemake.params.appearance,
    )
