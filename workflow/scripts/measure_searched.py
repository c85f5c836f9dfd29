"""Score every searched subset of one evaluation problem on its targets."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.ga_vs_learned import measure_searched
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    measure_searched(
        Path(snakemake.input.frames).parent,
        snakemake.input.split,
        snakemake.input.subsets,
        snakemake.output[0],
        reconstruction=snakemake.params.reconstruction,
        config=digest,
    )
