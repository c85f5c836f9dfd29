"""Count the frames of the captures."""

from typing import TYPE_CHECKING

from fsel.experiments.counts import counts

from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, counts)
