"""Draw selection time against the PSNR behind the search."""

from typing import TYPE_CHECKING

from fsel.pipeline.timing import speed_figure
from fsel.pipeline.workflow import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    named = zip(
        [*snakemake.params.problems, *snakemake.params.problems],
        [*snakemake.input.evaluations, *snakemake.input.oracles],
        strict=True,
    )
    evaluations = []
    for problem, path in named:
        dataset, scene, draw = problem.split("/")
        evaluations.append({"dataset": dataset, "scene": scene, "draw": draw, "path": path})
    speed_figure(snakemake.input.times, evaluations, snakemake.output, k=snakemake.params.k)
