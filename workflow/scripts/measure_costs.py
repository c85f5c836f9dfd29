"""Measure what selection and reconstruction cost on one evaluation scene."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.costs import measure_costs
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, measure_costs)
