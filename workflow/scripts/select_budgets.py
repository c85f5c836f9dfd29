"""Select adaptive and fixed numbers of frames of one evaluation scene."""

from typing import TYPE_CHECKING

from fsel.experiments.studies.budget import select_budgets
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, select_budgets)
