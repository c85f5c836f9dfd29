"""Cost of one reconstruction, measured in a process of its own (Linux).

Evaluations of one process share caches, and the memory that they hold.

`python -m fsel.experiments.studies.footprint` reads a request as JSON from its input and prints
the answer.
"""

from __future__ import annotations

import ctypes
import json
import re
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fsel.core.capture import Capture, Views
from fsel.core.files import File
from fsel.core.programs import MEMORY, Unfinished
from fsel.metrics import Metrics, score_views
from fsel.reconstruct import Model, Reconstructor, needs_gpu, reconstructor_of
from fsel.reconstruct.configured import Peak

REPEATS = 3  # fresh reconstructors, of whose seconds the median is taken
WARM = 4  # frames of a reconstruction that only compiles
STATUS = Path("/proc/self/status")
UNCHECKED = {-signal.SIGSEGV, -signal.SIGABRT}  # how native code ends that a limit refuses memory
THREADLESS = "can't start new thread"  # Python's word where it refuses the memory of a thread


def measure_alone(
    folder: File,
    frames: np.ndarray,
    targets: np.ndarray,
    reconstruction: Mapping,
    *,
    repeats: int = REPEATS,
    metrics: Metrics = ("psnr",),
    memory: int | None = None,
) -> dict[str, Any]:
    """Measure one reconstruction in a fresh process, so that no other's memory counts.

    `frames` are (K,), `targets` (T,); seconds are medians over `repeats` fresh reconstructors, of
    the processor, with a GPU of the clock; `memory` is in bytes beyond what the process holds
    before it.

    Returns:
        fit_seconds, render_seconds, the metrics, peak_bytes above the process, and device.

    Raises:
        Unfinished: when the reconstruction does not finish, or the memory does not suffice.
        RuntimeError: when the process fails otherwise.
    """
    request = {
        "folder": str(folder),
        "frames": np.sort(frames).tolist(),
        "targets": np.asarray(targets).tolist(),
        "reconstruction": dict(reconstruction),
        "repeats": repeats,
        "metrics": dict(metrics) if isinstance(metrics, Mapping) else list(metrics),
        "memory": memory,
    }
    command = [sys.executable, "-m", __spec__.name]
    done = subprocess.run(command, input=json.dumps(request), capture_output=True, text=True)
    if done.returncode:
        words = (done.stderr.strip() or f"exit code {done.returncode}").splitlines()[-1]
        full = done.returncode == -signal.SIGKILL or "MemoryError" in words
        full |= memory is not None and (done.returncode in UNCHECKED or THREADLESS in words)
        message = f"{folder}: {len(frames)} frames: {words}"
        raise Unfinished(MEMORY, message, done.stderr) if full else RuntimeError(message)
    answer = json.loads(done.stdout)
    if "outcome" in answer:
        raise Unfinished(answer["outcome"], f"{folder}: {len(frames)} frames", answer["log"])
    return answer


def footprint(
    folder: str,
    frames: list[int],
    targets: list[int],
    reconstruction: Mapping,
    repeats: int = REPEATS,
    metrics: Metrics = ("psnr",),
    memory: int | None = None,
) -> dict[str, Any]:
    """Measure in this process what `measure_alone` returns."""
    capture, chosen = Capture.load(folder), np.array(frames)
    views = capture.resized(reconstruction["long_side"]).view(np.array(targets))
    reconstructor_of(capture, reconstruction).fit(np.array(targets[:WARM])).render(views)
    reconstructor = reconstructor_of(capture, reconstruction)
    truth = np.asarray(reconstructor.capture.images[np.array(targets)])
    ctypes.CDLL(None).malloc_trim(0)  # or the freed memory of compiling would serve the fit
    gpu = needs_gpu(reconstruction)
    if memory is not None and not gpu:  # drivers of GPUs map far more than they use
        (mapped,) = re.findall(r"^VmData:\s*(\d+)", STATUS.read_text(), re.MULTILINE)
        most = 1024 * int(mapped) + memory
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))
    peak = Peak()
    rendered, model, *seconds = fit_and_render(reconstructor, chosen, views, gpu)
    taken = model.peak_bytes if gpu else max(peak.bytes, model.peak_bytes)
    runs = [tuple(seconds)]
    for _ in range(repeats - 1):
        fresh = reconstructor_of(capture, reconstruction)
        runs.append(fit_and_render(fresh, chosen, views, gpu)[2:])
    fitting, rendering = np.median(runs, axis=0)
    scores = score_views(rendered, truth, None, metrics)
    return {
        "fit_seconds": fitting,
        "render_seconds": rendering,
        "peak_bytes": taken,
        "device": model.device,
        **dict(zip(metrics, scores.mean(axis=0).tolist(), strict=True)),
    }


def fit_and_render(
    reconstructor: Reconstructor, frames: np.ndarray, views: Views, gpu: bool
) -> tuple[np.ndarray, Model, float, float]:
    """Return the rendered views, the model, and the seconds of fitting and of rendering."""
    started = _clock(gpu)
    model = reconstructor.fit(frames)
    fitted = _clock(gpu)
    rendered = model.render(views)
    return rendered, model, fitted - started, _clock(gpu) - fitted


def _clock(gpu: bool) -> float:
    """Return seconds of the processor, with those of children; with a GPU, of the clock."""
    if gpu:
        return time.perf_counter()
    others = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + others.ru_utime + others.ru_stime


if __name__ == "__main__":
    try:
        answer = footprint(**json.load(sys.stdin))
    except Unfinished as end:
        answer = {"outcome": end.outcome, "log": end.log}
    print(json.dumps(answer))
