"""Draw PSNR against noise in the poses."""

from typing import TYPE_CHECKING

from fsel.experiments.poses import of_scenes, pose_noise
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    pose_noise(
        of_scenes(snakemake.params.scenes, snakemake.input.noise),
        snakemake.output.figures,
        snakemake.output.numbers,
        bootstrap=snakemake.params.bootstrap,
        facts=snakemake.params.facts,
    )
