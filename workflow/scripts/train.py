"""Train scorers by behaviour cloning, one a seed."""

from typing import TYPE_CHECKING

from fsel.stages.train import train
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, train)
