"""Draw a search's population, and labels from above."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.pipeline_figure import pipeline_figure
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, pipeline_figure)
