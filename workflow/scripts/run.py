"""Run a rule: the function of its name, with what the rule names as its arguments."""

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from fsel.workflow.job import run

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

sys.path.append(str(Path(snakemake.scriptdir, "..", "..", "tools")))
run(snakemake)
# Python would take apart every module first, a fifth of the seconds of a short job
sys.stdout.flush()
sys.stderr.flush()
os._exit(0)
