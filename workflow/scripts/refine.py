"""Fit fsel's scorer to the quality of reconstructions."""

from typing import TYPE_CHECKING

from fsel.stages.refine import refine
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, refine)
