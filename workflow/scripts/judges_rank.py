"""Write how well two judges rank the same subsets."""

from typing import TYPE_CHECKING

from fsel.experiments.learning.judges_rank import judges_rank
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, judges_rank)
