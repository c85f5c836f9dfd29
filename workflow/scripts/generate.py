"""Generate one embedded capture in its dataset's own layout."""

from typing import TYPE_CHECKING

from fsel.stages.generate import generate
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, generate)
