"""Describe the appearance and the sharpness of one capture's frames."""

from typing import TYPE_CHECKING

from fsel.stages.describe import describe
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, describe)
