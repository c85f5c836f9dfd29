"""Order the searched subsets of all labelled scenes."""

from typing import TYPE_CHECKING

from fsel.stages.order import order
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, order)
