"""The memory that another process takes on GPUs, through NVIDIA's management library."""

from __future__ import annotations

import os
import threading
from types import ModuleType

from fsel.core.programs.outcome import NoDevice

EVERY = 0.2  # seconds between looks


def library() -> ModuleType:
    """`pynvml`, with the library behind it started.

    Raises:
        ImportError: when the package is not installed.
        NoDevice: when no driver or no GPU is there.
    """
    try:
        import pynvml
    except ImportError as error:
        raise ImportError(
            "gpu: true measures by pynvml, which is not installed. Hint: pip install 'fsel[cuda]'"
        ) from error
    try:
        pynvml.nvmlInit()
        count = pynvml.nvmlDeviceGetCount()
    except pynvml.NVMLError as error:
        raise NoDevice(f"gpu is true, and the NVIDIA driver does not answer: {error}") from error
    if not count:
        raise NoDevice("gpu is true, and there is no NVIDIA GPU")
    return pynvml


class Watch:
    """Looks at GPUs while a process group runs; looks at nothing where none is used.

    Memory is that of the group's processes. Where the driver does not tell processes apart, as in
    some containers, it is what all GPUs hold beyond what they held at the start.

    Args:
        group: its process group.
        gpu: whether to look.
    """

    def __init__(self, group: int, gpu: bool) -> None:
        self._group, self._gpu, self._done, self._most = group, gpu, threading.Event(), 0
        self.device = "cpu"
        if gpu:
            self._nvml = library()
            count = self._nvml.nvmlDeviceGetCount()
            self._devices = [self._nvml.nvmlDeviceGetHandleByIndex(at) for at in range(count)]
            name = self._nvml.nvmlDeviceGetName(self._devices[0])
            self.device = name if isinstance(name, str) else name.decode()
            self._start = self._held()
            self._thread = threading.Thread(target=self._look, daemon=True)

    @property
    def peak_bytes(self) -> int:
        """The most memory of all GPUs together."""
        return self._most

    def __enter__(self) -> Watch:
        if self._gpu:
            self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        if self._gpu:
            self._done.set()
            self._thread.join()

    def _look(self) -> None:
        while not self._done.wait(EVERY):
            self._most = max(self._most, self._own() or self._held() - self._start)

    def _held(self) -> int:
        memory = self._nvml.nvmlDeviceGetMemoryInfo
        return sum(int(memory(device).used) for device in self._devices)

    def _own(self) -> int:
        used = 0
        for device in self._devices:
            for process in self._nvml.nvmlDeviceGetComputeRunningProcesses(device):
                if _group(process.pid) == self._group:
                    used += process.usedGpuMemory or 0
        return used


def _group(process: int) -> int | None:
    try:
        return os.getpgid(process)
    except OSError:
        return None
