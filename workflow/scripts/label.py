"""Search for good subsets of one training scene."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.stages.job import job
from fsel.stages.label import label

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    label(
        Path(snakemake.input.frames).parent,
        dict(zip(snakemake.params.coverages, snakemake.output.labels, strict=True)),
        snakemake.output.splits,
        seed=snakemake.params.seed,
        search=snakemake.params.search,
        reconstruction=snakemake.params.reconstruction,
        inputs=snakemake.input,
        config=digest,
    )
