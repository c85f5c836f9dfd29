"""Read one capture into its canonical form."""

from pathlib import Path
from typing import TYPE_CHECKING

from fsel.stages.ingest import ingest
from fsel.stages.job import job

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

with job(snakemake):
    ingest(
        snakemake.input.capture,
        Path(snakemake.output.frames).parent,
        at_least=snakemake.params.at_least,
        long_side=snakemake.params.long_side,
        **snakemake.params.reading,
    )
