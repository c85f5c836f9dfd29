"""Run every method on every problem of one capture."""

from typing import TYPE_CHECKING

from fsel.stages.select import select
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, select)
