"""Generate one embedded capture in its dataset's own layout."""

from typing import TYPE_CHECKING

from fsel.stages.generate import generate
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    generate(
        snakemake.output[0],
        layout=snakemake.params.layout,
        family=snakemake.params.family,
        seed=snakemake.params.seed,
        **snakemake.params.size,
    )
