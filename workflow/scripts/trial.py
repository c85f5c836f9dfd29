"""Train one case with every seed and let it pick frames of validation scenes."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.ablation.trials import trial
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, trial)
