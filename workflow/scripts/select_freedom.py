"""Select frames with equal freedom."""

from typing import TYPE_CHECKING

from fsel.experiments.studies.candidate_pools import select_freedom
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, select_freedom)
