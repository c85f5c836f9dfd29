"""Fit fsel's scorer to the quality of reconstructions."""

from typing import TYPE_CHECKING

from fsel.stages.job import run
from fsel.stages.refine import refine

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, refine)
