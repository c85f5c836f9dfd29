"""Run every hard case."""

from typing import TYPE_CHECKING

from fsel.experiments.stability import stability
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, stability)
