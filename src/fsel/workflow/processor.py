"""One kind of processor for all jobs: results then have the same bytes on all of x86-64-v3.

Compiled functions, NumPy, OpenBLAS, MKL, oneDNN, torch and OpenCV look at the processor and choose
wider vectors, where there are any, which sum in another order. Their own variables keep them to
AVX2 and FMA, which x86-64-v3 has: Intel since 2013, AMD since 2015. What is left is in
docs/numerics.md.
"""

from __future__ import annotations

import platform
from pathlib import Path

LEVEL = {"avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"}  # of x86-64-v3, as the kernel names them

PINNED = {
    "NUMBA_CPU_NAME": "haswell",
    "NUMBA_CPU_FEATURES": "",  # the processor's own would be added to what the name says
    "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR",
    "OPENBLAS_CORETYPE": "Haswell",
    "MKL_CBWR": "COMPATIBLE",  # the one branch that MKL runs on processors of all makers
    "ONEDNN_MAX_CPU_ISA": "AVX2",
    "ATEN_CPU_CAPABILITY": "avx2",
    "OPENCV_CPU_DISABLE": "AVX512-SKX",
    "OPENCV_IPP": "avx2",
}


def environment(cpuinfo: Path = Path("/proc/cpuinfo")) -> dict[str, str]:
    """Return the variables that a job's environment needs before Python starts.

    There are none on other architectures, and on processors below x86-64-v3: there results agree
    but for their last digits.

    Args:
        cpuinfo: where Linux lists the processor's features; without it x86-64-v3 is taken to be.
    """
    if platform.machine() not in ("x86_64", "AMD64"):
        return {}
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    features = next((set(line.split()) for line in lines if line.startswith("flags")), LEVEL)
    return dict(PINNED) if features >= LEVEL else {}
