"""Select on poses with noise."""

from typing import TYPE_CHECKING

from fsel.experiments.pose_trials import select_noise
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, select_noise)
