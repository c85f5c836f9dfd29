"""The GPU that some reconstructors work on, through torch; taken by name, never assumed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from fsel.core.programs.outcome import MEMORY, NoDevice, Unfinished
from fsel.reconstruct import memory

DEVICES = ("cpu", "cuda")


def check_name(device: str) -> None:
    """Refuse what is none of `DEVICES`."""
    if device not in DEVICES:
        raise ValueError(f"device must be one of {', '.join(DEVICES)}, got {device!r}")


def check(device: str) -> None:
    """Refuse a GPU that is not there, or one without the rasteriser for it.

    Raises:
        ImportError: when torch or gsplat is not installed.
        NoDevice: when torch finds no GPU.
    """
    if device == "cpu":
        return
    try:
        import torch
    except ImportError as error:
        raise ImportError("device: cuda needs torch. Hint: pip install 'fsel[cuda]'") from error
    try:
        import gsplat
    except ImportError as error:
        raise ImportError(
            "device: cuda renders by gsplat, which is not installed. Hint: pip install 'fsel[cuda]'"
        ) from error
    del gsplat
    if not torch.cuda.is_available():
        raise NoDevice(
            f"device is cuda, and torch {torch.__version__} finds no GPU. Hint: device: cpu, or a "
            "machine with a GPU and a build of torch for it"
        )


def name() -> str:
    """Name of the GPU in use."""
    import torch

    return torch.cuda.get_device_name()


def finish() -> None:
    """Wait for what the GPU was told to do, so that a clock can be read."""
    import torch

    torch.cuda.synchronize()


class Peak:
    """The most memory that a piece of work took, above what was held at the start.

    Of the GPU by torch's own counters, which see torch's tensors alone; else of this process, see
    `fsel.reconstruct.memory.Peak`.

    Args:
        device: one of `DEVICES`.
    """

    def __init__(self, device: str) -> None:
        self._resident = memory.Peak() if device == "cpu" else None
        if device == "cuda":
            import torch

            torch.cuda.synchronize()
            torch.cuda.reset_peak_memory_stats()
            self._start = torch.cuda.memory_allocated()

    @property
    def bytes(self) -> int:
        """Largest number of bytes added since the start."""
        if self._resident is not None:
            return self._resident.bytes
        import torch

        return max(torch.cuda.max_memory_allocated() - self._start, 0)


@contextmanager
def memory_errors(what: str) -> Iterator[None]:
    """Turn torch's and Python's errors of full memory into one outcome.

    Args:
        what: was being done, in words.

    Raises:
        Unfinished: out of memory.
    """
    import torch

    try:
        yield
    except (torch.cuda.OutOfMemoryError, MemoryError) as error:
        raise Unfinished(MEMORY, f"{what}: {error}") from error
