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


def test_of_two_processes_one_compiles(tmp_path):
    given = {
        "args": [sys.executable, "-c", PROGRAM],
        "env": os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
        "stdout": subprocess.PIPE,
        "text": True,
    }
    started = [subprocess.Popen(**given) for _ in range(2)]
    said = sorted(process.communicate()[0] for process in started)
    assert said == ["0 0 True\n", "1 1 True\n"]
