"""Score the picks inside the masks of one capture's object."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.objectcentric import evaluate_objects
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_objects)
