"""Select adaptive and fixed numbers of frames of one evaluation scene."""

from typing import TYPE_CHECKING

from fsel.experiments.budget import select_budgets
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, select_budgets)
