"""What all tests start with: the environment, set before anything compiles, and their order.

What is compiled here is what the jobs of the workflow run, so that the tests that start jobs, and
runs of the workflow in this checkout, find it; `tools/processors.py` compiles for other processors.
"""

import os
from pathlib import Path

from fsel.workflow.machine import pinned

# Of two workers one begins with the first half, which compiles nearly all; the other with what
# takes longest and compiles little. In the other order one would wait for what the other compiles.
FIRST = [
    "reconstruct", "selectors", "metrics", "synthetic", "core", "features", "fuzz", "evaluation",
    "selection", "workflow", "captures", "stages", "test_recipes.py",
]  # fmt: skip

for name, value in pinned().items():
    if name.startswith("NUMBA_"):
        os.environ.setdefault(name, value)
# each worker of pytest has one core: two that share two cores wait for each other's threads, and
# torch is ten times as slow
os.environ.setdefault("OMP_NUM_THREADS", "1")


def pytest_collection_modifyitems(items):
    """Order the tests by the room that they are of."""

    def place(item):
        room = item.path.relative_to(Path(__file__).parent).parts[0]
        return FIRST.index(room) if room in FIRST else len(FIRST)

    items.sort(key=place)
