"""Write what labels by another reconstructor change."""

from typing import TYPE_CHECKING

from fsel.experiments.label_judge import label_judge
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, label_judge)
