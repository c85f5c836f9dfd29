"""Compare selection and training in several precisions."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.experiments.precision import precision
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    given, asked = snakemake.input, snakemake.params
    problems = [
        {"label": label, "name": name, "folder": Path(frames).parent, "split": split}
        for label, name, frames, split in zip(
            asked.labels, asked.problems, given.frames, given.splits, strict=True
        )
    ]
    named = zip(asked.scenes, given.trained_frames, given.trained_splits, strict=True)
    scenes = {s: (Path(frames).parent, split) for s, frames, split in named}
    precision(
        problems,
        {"ours": given.ours, "fsel": given.fsel},
        {"scenes": scenes, "trajectories": given.trajectories, **asked.training},
        snakemake.output.table,
        snakemake.output.numbers,
        k=asked.k,
        reconstruction=asked.reconstruction,
        facts=asked.facts,
    )
