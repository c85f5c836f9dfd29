"""Search for good subsets of one training scene."""

from typing import TYPE_CHECKING

from fsel.stages.label import label
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, label)
