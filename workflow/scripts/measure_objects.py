"""Measure every method on the object of one capture."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.objectcentric import TRAINED, measure_objects
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    measure_objects(
        Path(snakemake.input.frames).parent,
        {name: list(snakemake.input[name]) for name in TRAINED},
        snakemake.output[0],
        **snakemake.params.problem,
        seed=snakemake.params.seed,
        reconstruction=snakemake.params.reconstruction,
        config=digest,
    )
