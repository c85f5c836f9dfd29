"""Unpack one scene of an archive."""

from typing import TYPE_CHECKING

from fsel.stages.job import run
from fsel.stages.unpack import unpack

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, unpack)
