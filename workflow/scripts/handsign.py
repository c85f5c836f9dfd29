"""Write what learning adds to the untrained sum."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.handsign import handsign
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, handsign)
