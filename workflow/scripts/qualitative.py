"""Draw what several selections reconstruct."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.qualitative import qualitative
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, qualitative)
