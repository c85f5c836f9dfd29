"""Order the searched subsets of all labelled scenes."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.stages.job import job
from fsel.stages.label import trajectories

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake) as digest:
    coverages = snakemake.params.coverages
    items = []
    for i, (scene, role) in enumerate(snakemake.params.scenes.items()):
        paths = snakemake.input.labels[i * len(coverages) : (i + 1) * len(coverages)]
        items.append(
            {
                "scene": scene,
                "role": role,
                "folder": Path(snakemake.input.frames[i]).parent,
                "splits": snakemake.input.splits[i],
                "labels": dict(zip(coverages, paths, strict=True)),
            }
        )
    trajectories(items, snakemake.output[0], kept=snakemake.params.kept, config=digest)
