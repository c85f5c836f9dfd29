"""Fit what the adaptive budget predicts."""

from typing import TYPE_CHECKING

from fsel.experiments.budget_curves import fit_budget
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    scenes = [name.split("/") for name in snakemake.params.scenes]
    fit_budget(
        [
            {"dataset": dataset, "scene": scene, "path": path}
            for (dataset, scene), path in zip(scenes, snakemake.input.curves, strict=True)
        ],
        snakemake.output.record,
        snakemake.output.comparison,
        config=digest,
    )
