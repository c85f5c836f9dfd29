"""Select on poses with noise."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.pose_trials import select_noise
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, select_noise)
