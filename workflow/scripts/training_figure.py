"""Draw loss and agreement over epochs."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.training_figure import training_figure
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, training_figure)
