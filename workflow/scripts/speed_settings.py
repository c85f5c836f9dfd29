"""Measure the reconstructor's settings on the first draw of every evaluation scene."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.speed_settings import speed_settings
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    named = zip(
        snakemake.input.frames, snakemake.input.splits, snakemake.params.generated, strict=True
    )
    speed_settings(
        [
            {"folder": Path(frames).parent, "split": split, "generated": generated}
            for frames, split, generated in named
        ],
        snakemake.output[0],
        k=snakemake.params.k,
        reconstruction=snakemake.params.reconstruction,
    )
