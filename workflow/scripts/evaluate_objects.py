"""Score the picks inside the masks of one capture's object."""

from typing import TYPE_CHECKING

from fsel.experiments.objectcentric import evaluate_objects
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_objects)
