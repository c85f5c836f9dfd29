"""Train one scorer with some features at zero."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.ablation.variants import train_variant
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    scenes = {}
    for i, scene in enumerate(snakemake.params.scenes):
        folder = Path(snakemake.input.frames[i]).parent
        scenes[scene] = (folder, snakemake.input.splits[i])
    train_variant(
        scenes,
        snakemake.input.trajectories,
        snakemake.output[0],
        name=snakemake.params.name,
        seed=int(snakemake.wildcards.seed),
        epochs=snakemake.params.epochs,
        learning_rate=snakemake.params.learning_rate,
        config=digest,
    )
