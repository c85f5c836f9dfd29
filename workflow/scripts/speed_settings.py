"""Measure the reconstructor's settings on the first draw of every evaluation scene."""

from typing import TYPE_CHECKING

from fsel.experiments.studies.speed_settings import speed_settings
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, speed_settings)
