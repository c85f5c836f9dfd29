"""Draw quality, time and memory against the number of frames."""

from typing import TYPE_CHECKING

from fsel.experiments.costs import saturation
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, saturation)
