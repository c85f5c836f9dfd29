"""Functions that are compiled: once for all processes."""

import os
import subprocess
import sys

PROGRAM = """
from fsel.core import limits
from fsel.core.helpers import _look
import numpy as np

seconds = []
limits.WHEN_COMPILED.append(seconds.append)
one = np.ones(1, np.int64)
_look(one, 1, one)
print(len(seconds), sum(_look.stats.cache_misses.values()), all(s > 0 for s in seconds))
"""


def said(folder, processes):
    """What processes that start together print, in the alphabet's order."""
    given = {
        "args": [sys.executable, "-c", PROGRAM],
        "env": os.environ | {"NUMBA_CACHE_DIR": str(folder)},
        "stdout": subprocess.PIPE,
        "text": True,
    }
    started = [subprocess.Popen(**given) for _ in range(processes)]
    return sorted(process.communicate()[0] for process in started)


def test_of_two_processes_one_compiles_and_what_was_cut_is_compiled_anew(tmp_path):
    assert said(tmp_path, 2) == ["0 0 True\n", "1 1 True\n"]
    for ending in ("nbi", "nbc"):
        (stored,) = tmp_path.rglob(f"*_look*.{ending}")
        stored.write_bytes(stored.read_bytes()[:-9])
        assert said(tmp_path, 1) == ["1 1 True\n"]
    assert said(tmp_path, 1) == ["0 0 True\n"]
