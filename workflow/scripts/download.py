"""Fetch one archive, going on where an earlier run was cut off."""

from typing import TYPE_CHECKING

from fsel.stages.download import download
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, download)
