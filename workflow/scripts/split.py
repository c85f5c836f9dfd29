"""Draw the targets of one capture."""

from typing import TYPE_CHECKING

from fsel.stages.job import run
from fsel.stages.split import split

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, split)
