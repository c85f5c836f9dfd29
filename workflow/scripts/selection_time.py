"""Time every method over pools of several sizes."""

from typing import TYPE_CHECKING

from fsel.experiments.studies.selection_time import selection_time
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, selection_time)
