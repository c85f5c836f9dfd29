"""Write how far training seeds spread."""

from typing import TYPE_CHECKING

from fsel.experiments.seedvar import seedvar
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, seedvar)
