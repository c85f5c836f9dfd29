"""Hold out every pass of one room in turn."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.crosscapture import measure_crosscapture
from fsel.selector.policies import POLICIES
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    measure_crosscapture(
        Path(snakemake.input.frames).parent,
        {name: list(snakemake.input[name]) for name in POLICIES},
        snakemake.output[0],
        budgets=snakemake.params.budgets,
        seed=snakemake.params.seed,
        reconstruction=snakemake.params.reconstruction,
        config=digest,
    )
