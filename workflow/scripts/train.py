"""Train scorers by behaviour cloning, one a seed."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.stages.job import job
from fsel.stages.train import clone

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    scenes = {}
    for i, scene in enumerate(snakemake.params.scenes):
        folder = Path(snakemake.input.frames[i]).parent
        scenes[scene] = (folder, snakemake.input.splits[i])
    clone(
        scenes,
        snakemake.input.trajectories,
        snakemake.output.weights,
        snakemake.output.logs,
        policy=snakemake.params.policy,
        epochs=snakemake.params.epochs,
        learning_rate=snakemake.params.learning_rate,
        config=digest,
    )
