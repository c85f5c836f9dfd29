"""Draw what several selections reconstruct."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.qualitative import qualitative
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    qualitative(
        Path(snakemake.input.frames).parent,
        snakemake.input.split,
        snakemake.input.selections,
        snakemake.output.figures,
        snakemake.output.numbers,
        methods=snakemake.params.methods,
        views=snakemake.params.views,
        k=snakemake.params.k,
        reconstruction=snakemake.params.reconstruction,
        facts=snakemake.params.facts,
    )
