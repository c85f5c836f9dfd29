"""Time every method over pools of several sizes."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.selection_time import selection_time
from fsel.selector.policies import POLICIES
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    selection_time(
        Path(snakemake.input.frames).parent,
        {name: list(snakemake.input[name]) for name in POLICIES},
        snakemake.output.table,
        snakemake.output.numbers,
        pools=snakemake.params.pools,
        k=snakemake.params.k,
        targets=snakemake.params.targets,
        appearance=snakemake.params.appearance,
    )
