"""Search for good subsets of one training scene."""

from typing import TYPE_CHECKING

from fsel.stages.job import run
from fsel.stages.label import label

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, label)
