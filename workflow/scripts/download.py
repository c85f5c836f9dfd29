"""Fetch one archive, going on where an earlier run was cut off."""

from typing import TYPE_CHECKING

from fsel.stages.download import download
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    download(
        snakemake.params.archive["url"],
        snakemake.output[0],
        sha256=snakemake.params.archive["sha256"],
    )
