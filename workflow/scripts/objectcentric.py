"""Write the object-centric table."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.objectcentric import objectcentric
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, objectcentric)
