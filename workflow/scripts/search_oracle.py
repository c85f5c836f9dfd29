"""Search one evaluation problem, to compare selection with."""

from typing import TYPE_CHECKING

from fsel.stages.search_oracle import search_oracle
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, search_oracle)
