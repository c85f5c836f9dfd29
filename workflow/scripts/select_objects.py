"""Select views of the object of one capture."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.objectcentric import select_objects
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, select_objects)
