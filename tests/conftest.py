"""What all tests start with: the environment, set before anything compiles.

What is compiled here is what the jobs of the workflow run, so that the tests that start jobs, and
runs of the workflow in this checkout, find it; `tools/processors.py` compiles for other processors.
"""

import gc
import os

import pytest

from fsel.workflow.machine import pinned

for name, value in pinned().items():
    if name.startswith("NUMBA_"):
        os.environ.setdefault(name, value)
# each worker of pytest has one core: two that share two cores wait for each other's threads, and
# torch is ten times as slow
os.environ.setdefault("OMP_NUM_THREADS", "1")
gc.disable()  # what is imported stays: a fifth of the time of collecting would look at it


def pytest_collection_finish():
    gc.freeze()
    gc.enable()


@pytest.fixture
def capture(tmp_path):
    """A folder with a small COLMAP capture."""
    from small_captures import write_ring

    write_ring(tmp_path / "capture")
    return tmp_path / "capture"


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """The folder of found poses and fetched weights, empty for each test."""
    monkeypatch.setenv("FSEL_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def quick_trials(monkeypatch):
    """Selections are validated by few fits of few steps; tests/selection/test_halving.py has real
    ones."""
    from fsel.selection import halving, small_fits

    monkeypatch.setitem(small_fits.SETTINGS, "steps", 5)
    monkeypatch.setattr(halving, "MOST_SHARES", 1)
    monkeypatch.setattr(halving, "KNOWN_SHARES", 1)
    monkeypatch.setattr(halving, "ROUND_SECONDS", 40.0)
