"""Unpack one scene of an archive."""

from typing import TYPE_CHECKING

from fsel.pipeline.downloads import unpack
from fsel.pipeline.workflow import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    unpack(snakemake.input.archive, snakemake.params.inside, snakemake.output[0])
