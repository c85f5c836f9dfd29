"""What selecting must not import."""

import subprocess
import sys

PROGRAM = """
import sys
import fsel
from fsel.selector.greedy import greedy
from fsel.selector.policies import POLICIES
from fsel.selector.scorer import Network
from fsel.experiments.hard_cases.worlds import random_weights, world

problem = world()
fsel.select(problem.capture, 6)
fsel.select(problem.capture, 6, method="untrained")
greedy(POLICIES["ours"].prepare(problem), Network(random_weights(0)), 6)
print(*{"torch", "cma", "snakemake", "matplotlib"} & set(sys.modules))
"""


def test_neither_torch_nor_what_only_experiments_need():
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == []
