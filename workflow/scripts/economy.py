"""Measure what modelling only what a scene needs removes and costs."""

from typing import TYPE_CHECKING

from fsel.experiments.studies.economy import economy
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, economy)
