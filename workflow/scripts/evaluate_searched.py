"""Score every searched subset of one evaluation problem on its targets."""

from typing import TYPE_CHECKING

from fsel.experiments.paper.ga_vs_learned import evaluate_searched
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, evaluate_searched)
