"""Jobs as forks of one process that has imported what they need.

A job of the default run takes a few seconds, and one of them was a start of Python with NumPy,
OpenCV and numba. Only jobs that run here, on Linux, in this environment and on one thread are
forked: other systems' libraries do not survive a fork, and pools of threads are sized as a library
is imported.
"""

from __future__ import annotations

import multiprocessing
import os
import runpy
import subprocess
import sys
from multiprocessing import forkserver
from pkgutil import iter_modules

from snakemake import benchmark, script

import fsel.stages

PRELOADED = [
    "snakemake.cli",
    "fsel.workflow.job",
    *(f"fsel.stages.{module.name}" for module in iter_modules(fsel.stages.__path__)),
]
MANY = 8
LOOKS = 2.0  # seconds between looks at a job's memory, each of which takes tens of milliseconds
ONE_THREAD = dict.fromkeys(
    ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS"], "1"
)


class ForkedScript(script.PythonScript):
    """A script of Snakemake's that runs in a fork where it would run in a Python of its own."""

    def execute_script(self, fname: str, edit: bool = False) -> None:
        """Run the script that Snakemake wrote.

        Raises:
            subprocess.CalledProcessError: as Snakemake's own does, where it fails.
        """
        elsewhere = self.conda_env or self.container_img or self.env_modules
        if elsewhere or self.threads != 1:
            super().execute_script(fname, edit)
            return
        context = multiprocessing.get_context("forkserver")
        process = context.Process(target=_run, args=(fname, self.resources.get("tmpdir")))
        process.daemon = True
        process.start()
        with benchmark.benchmarked(process.pid, self.bench_record):
            process.join()
        if process.exitcode:
            raise subprocess.CalledProcessError(process.exitcode, [sys.executable, fname])


def _run(file: str, temporary: str | None) -> None:
    """Run a script in a fork, with the folder for temporary files that Snakemake gives it."""
    if temporary:
        os.environ["TMPDIR"] = temporary
    runpy.run_path(file, run_name="__main__")


def fork_jobs(jobs: int) -> None:
    """Fork the jobs of this process of Snakemake from now on, where the system can and where they
    are many enough to save more than it takes to import all that any of them needs."""
    if sys.platform != "linux" or jobs < MANY:
        return
    before = dict(os.environ)
    os.environ.update(ONE_THREAD)
    multiprocessing.set_forkserver_preload(PRELOADED)
    forkserver.ensure_running()
    os.environ.clear()
    os.environ.update(before)
    script.PythonScript, benchmark.BENCHMARK_INTERVAL_SHORT = ForkedScript, LOOKS
