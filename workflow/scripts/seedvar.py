"""Write how far training seeds spread."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.seedvar import seedvar
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, seedvar)
