"""The environment that jobs inherit.

Compiled functions, NumPy, OpenBLAS, MKL, oneDNN, torch and OpenCV choose wider vectors where the
processor has them, which sum in another order. `PINNED` keeps all of them to AVX2 and FMA, which
every x86-64-v3 processor has (Intel since 2013, AMD since 2015), so that results have the same
bytes there. What is left is in docs/numerics.md.
"""

from __future__ import annotations

import os
import platform
import sys
from importlib.metadata import version
from pathlib import Path

# bytes: every evaluation makes and drops arrays of megabytes: glibc would return their pages to
# the kernel each time and request them anew, 8 % of a search
INHERITED = dict.fromkeys(["MALLOC_MMAP_THRESHOLD_", "MALLOC_TRIM_THRESHOLD_"], str(32 << 20))
LEVEL = {"avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"}  # of x86-64-v3, as the kernel names them
WIDE = {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}  # OpenCV's AVX512-SKX
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


def pinned(cpuinfo: Path = Path("/proc/cpuinfo")) -> dict[str, str]:
    """Return the variables that keep libraries to x86-64-v3, set before Python starts; none on
    other architectures and older processors, whose last digits may differ."""
    if platform.machine() not in ("x86_64", "AMD64"):
        return {}
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    flags = (set(line.split()) for line in lines if line.startswith("flags"))
    features = next(flags, LEVEL | WIDE)
    if not features >= LEVEL:
        return {}
    # each process of OpenCV complains of what it is to switch off and does not find
    wide = features >= WIDE
    return {k: v for k, v in PINNED.items() if wide or k != "OPENCV_CPU_DISABLE"}


def prepare(clone: Path | None, verbose: bool = False) -> None:
    """Set what every job inherits, unless it is set already, and print what is set otherwise where
    `verbose`; jobs run the library of a clone of the repository, or the installed one."""
    if clone is not None:
        found = os.environ.get("PYTHONPATH", "").split(os.pathsep)
        search = dict.fromkeys([str(clone / "src"), *found])
        os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, search))
    # what workflow/envs/fsel.post-deploy.sh installs
    source = f"fsel[workflow]=={version('fsel')}" if clone is None else f"{clone}[workflow]"
    os.environ["FSEL"] = source
    own = pinned()
    for name, value in {**INHERITED, **own}.items():
        os.environ.setdefault(name, value)
    for name, value in own.items() if verbose else ():
        if os.environ[name] != value:
            print(
                f"{name} is set to {os.environ[name]!r}, not {value!r}: the last digits of results "
                f"may differ from those of other machines. Hint: unset {name}",
                file=sys.stderr,
            )
    # images of containers often set it: every job would compile pandas anew, a second each
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
