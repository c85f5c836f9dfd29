"""Memory of a GPU by NVIDIA's library, with a stand-in for it: which processes count."""

import os
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest

from fsel.core.programs import nvml
from fsel.reconstruct import check_needs


class StandIn(SimpleNamespace):
    """Two GPUs; processes by GPU, as (pid, bytes); bytes held by GPU."""

    NVMLError = RuntimeError

    def nvmlInit(self):
        if self.broken:
            raise self.NVMLError("driver not loaded")

    def nvmlDeviceGetCount(self):
        return len(self.held)

    def nvmlDeviceGetHandleByIndex(self, at):
        return at

    def nvmlDeviceGetName(self, at):
        return b"Stand-in"

    def nvmlDeviceGetMemoryInfo(self, at):
        return SimpleNamespace(used=self.held[at])

    def nvmlDeviceGetComputeRunningProcesses(self, at):
        return [SimpleNamespace(pid=p, usedGpuMemory=size) for p, size in self.processes[at]]


@pytest.fixture
def stand_in(monkeypatch):
    found = StandIn(broken=False, held=[100, 50], processes=[[], []])
    monkeypatch.setitem(sys.modules, "pynvml", found)
    monkeypatch.setattr(nvml, "EVERY", 0.01)
    return found


def peak(stand_in, group, change):
    with nvml.Watch(group, True) as watch:
        time.sleep(0.05)
        change()
        time.sleep(0.1)
        stand_in.held = [100, 50]
        stand_in.processes = [[], []]
        time.sleep(0.05)
    assert watch.device == "Stand-in"
    return watch.peak_bytes


def test_the_groups_processes_on_all_gpus_count_and_no_others(stand_in):
    other = subprocess.Popen(["sleep", "30"], start_new_session=True)

    def change():
        stand_in.processes = [[(os.getpid(), 70), (other.pid, 1000)], [(os.getpid(), 5)]]

    try:
        assert peak(stand_in, os.getpgid(0), change) == 75
    finally:
        other.kill()
        other.wait()


def test_where_processes_are_not_told_apart_what_came_on_top_counts(stand_in):
    assert peak(stand_in, 1, lambda: setattr(stand_in, "held", [400, 50])) == 300


def test_a_gpu_that_is_not_there_is_refused(stand_in, monkeypatch):
    asked = {"name": "external", "settings": {"render": ["true"], "gpu": True}}
    check_needs(asked)
    stand_in.broken = True
    with pytest.raises(ValueError, match="driver does not answer: driver not loaded"):
        check_needs(asked)
    check_needs(asked, devices=False)  # the jobs of a cluster may have one
    monkeypatch.setitem(sys.modules, "pynvml", None)
    with pytest.raises(
        ValueError, match=r"pynvml, which is not installed. Hint: pip install 'fsel"
    ):
        check_needs(asked)
