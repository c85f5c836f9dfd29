"""Run a rule: the function of its name, with what the rule names as its arguments."""

from typing import TYPE_CHECKING

from fsel.workflow.job import leave, run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

run(snakemake)
leave()
