"""Search for good subsets of a training scene's requests."""

from typing import TYPE_CHECKING

from fsel.stages.job import run
from fsel.stages.label_requests import label_requests

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, label_requests)
