"""Draw the targets of one capture."""

from typing import TYPE_CHECKING

from fsel.stages.split import split
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, split)
