"""Train one case with every seed and let it pick frames of validation scenes."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.ablation.trials import Case, trial
from fsel.report.sweep import named
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    given, params = snakemake.input, snakemake.params
    scenes = {}
    for i, scene in enumerate(params.scenes):
        scenes[scene] = (Path(given.frames[i]).parent, given.splits[i])
    validation = named(params.problems, given.validation_splits)
    trial(
        Case(**params.case),
        scenes,
        given.trajectories,
        [item | {"folder": Path(item["path"]).parent.parent} for item in validation],
        snakemake.output[0],
        k=params.k,
        seeds=params.seeds,
        epochs=params.epochs,
        learning_rate=params.learning_rate,
        config=digest,
    )
