"""Select ever more frames of one training scene."""

from typing import TYPE_CHECKING

from fsel.experiments.studies.budget_curves import select_curves
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, select_curves)
