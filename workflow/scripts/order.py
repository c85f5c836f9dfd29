"""Order the searched subsets of all labelled scenes."""

from typing import TYPE_CHECKING

from fsel.stages.job import run
from fsel.stages.order import order

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, order)
