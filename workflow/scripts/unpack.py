"""Unpack one scene of an archive."""

from typing import TYPE_CHECKING

from fsel.stages.download import unpack
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    unpack(snakemake.input.archive, snakemake.params.inside, snakemake.output[0])
