"""Compare selection and training in several precisions."""

from typing import TYPE_CHECKING

from fsel.experiments.studies.precision import precision
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, precision)
