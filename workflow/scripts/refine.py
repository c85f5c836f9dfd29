"""Fit fsel's scorer to the quality of reconstructions."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.stages.job import job
from fsel.stages.train import refined

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    folders = [Path(path).parent for path in snakemake.input.frames]
    refined(
        dict(zip(snakemake.params.scenes, folders, strict=True)),
        snakemake.output.weights,
        snakemake.output.log,
        seed=int(snakemake.wildcards.seed),
        settings=snakemake.params.settings,
        reconstruction=snakemake.params.reconstruction,
        inputs=snakemake.input,
        config=digest,
    )
