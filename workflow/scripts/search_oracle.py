"""Search one evaluation problem, to compare selection with."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.stages.job import job
from fsel.stages.select import search_oracle

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    search_oracle(
        Path(snakemake.input.frames).parent,
        snakemake.input.split,
        snakemake.output.subsets,
        snakemake.output.oracle,
        search=snakemake.params.search,
        reconstruction=snakemake.params.reconstruction,
        seed=snakemake.params.seed,
        inputs=snakemake.input,
        config=digest,
    )
