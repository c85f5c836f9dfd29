"""Snakemake in forks of a process that has imported it: most of a dry run is imports.

A program of its own: `dry_runs` starts it, and it ends when its input does. It reads a line for
each run, the folder, the words after `snakemake`, the environment and the files for stdout and
stderr, and answers with the exit code. The library is imported by the fork: tests change it.
"""

import gc
import json
import os
import sys
from importlib import import_module

from snakemake.cli import main

LIBRARIES = (
    "cv2",
    "numba",
    "pandas",
    "pyarrow.parquet",
    "scipy.interpolate",
    "scipy.spatial.transform",
)


def become(folder: str, words: list[str], variables: dict[str, str], files: list[str]) -> None:
    """Run `snakemake WORDS` and end this process as it does."""
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(variables)
    for number, file in enumerate(files, 1):
        os.dup2(os.open(file, os.O_WRONLY), number)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    sys.path[:0] = filter(None, variables.get("PYTHONPATH", "").split(os.pathsep))
    sys.argv = ["snakemake", *words]
    main()


if __name__ == "__main__":
    for name in LIBRARIES:
        import_module(name)
    gc.freeze()
    for line in sys.stdin:
        process = os.fork()
        if not process:
            become(*json.loads(line))
        print(os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]), flush=True)
