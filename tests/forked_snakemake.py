"""Snakemake in forks of a process that has imported it: most of a dry run is imports.

A program of its own: `dry_runs` starts it, and it ends when its input does. It reads a line for
each run, the folder, the words after `snakemake`, the environment and the files for stdout and
stderr, and answers with the exit code. The library of this checkout is imported too, and a fork
that runs another Snakefile, beside a changed copy of the library maybe, imports its own.
"""

import gc
import json
import os
import sys
from importlib import import_module
from pathlib import Path

from snakemake.cli import main

ROOT = Path(__file__).resolve().parents[1]
LIBRARIES = (
    "cv2",
    "pyarrow.parquet",
    "scipy.interpolate",
    "scipy.spatial.transform",
    # of Snakemake, when it starts
    "snakemake.report.html_reporter",
    "snakemake.storage",
    "smart_open",
    "yte",
)
PARTS = ("fsel.workflow.cases", "fsel.workflow.machine", "fsel.workflow.paper")


def import_library() -> None:
    """Import what a plan of the workflow needs."""
    sys.path.insert(0, str(ROOT / "src"))
    for name in (*LIBRARIES, *PARTS):
        import_module(name)
    sys.path.pop(0)


def forget_library() -> None:
    """Import the library anew when it is asked for."""
    for name in [name for name in sys.modules if name.partition(".")[0] == "fsel"]:
        del sys.modules[name]


def become(folder: str, words: list[str], variables: dict[str, str], files: list[str]) -> None:
    """Run `snakemake WORDS` and end this process as it does."""
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(variables)
    for number, file in enumerate(files, 1):
        os.dup2(os.open(file, os.O_WRONLY), number)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    sys.path[:0] = filter(None, variables.get("PYTHONPATH", "").split(os.pathsep))
    if str(ROOT / "Snakefile") not in words:
        forget_library()
    sys.argv = ["snakemake", *words]
    main()


if __name__ == "__main__":
    import_library()
    gc.disable()
    gc.freeze()
    for line in sys.stdin:
        process = os.fork()
        if not process:
            become(*json.loads(line))
        print(os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]), flush=True)
