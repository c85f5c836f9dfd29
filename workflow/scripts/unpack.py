"""Unpack one scene of an archive."""

from typing import TYPE_CHECKING

from fsel.stages.unpack import unpack
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, unpack)
