"""Run every method on every problem of one capture."""

from typing import TYPE_CHECKING

from fsel.stages.job import run
from fsel.stages.select import select

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, select)
