"""Judge labelled subsets of one scene again."""

from typing import TYPE_CHECKING

from fsel.experiments.learning.judging import judge_requests
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, judge_requests)
