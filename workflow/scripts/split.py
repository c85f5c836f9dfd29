"""Draw the targets of one capture."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.stages.job import job
from fsel.stages.split import split

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    split(
        Path(snakemake.input.frames).parent,
        snakemake.output,
        targets=snakemake.params.targets,
        seed=snakemake.params.seed,
        config=digest,
    )
