"""Learn from labelled requests in one way."""

from typing import TYPE_CHECKING

from fsel.experiments.learning.learn import learn
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, learn)
