"""Compute the raw features of one capture's problems."""

from typing import TYPE_CHECKING

from fsel.stages.features import features
from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake, features)
