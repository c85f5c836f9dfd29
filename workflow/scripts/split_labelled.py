"""Draw the targets of a labelled scene at every coverage level."""

from typing import TYPE_CHECKING

from fsel.stages.split_labelled import split_labelled
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, split_labelled)
