"""Learn from labelled requests with every set of inputs."""

from typing import TYPE_CHECKING

from fsel.experiments.learning.learn import learn_inputs
from fsel.stages.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, learn_inputs)
