"""Train one case with every seed and let it pick frames of validation scenes."""

from typing import TYPE_CHECKING

from fsel.experiments.ablation.trials import trial
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, trial)
