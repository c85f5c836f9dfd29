"""Ways to compile a function with numba.

The order in which sums are fastest depends on the processor, and with it their last digits. Values
that are cut to an integer, compared or ranked are computed by functions that `exact` compiles; sums
that are results in themselves may be `reordered`: equal bytes on equal instructions, see
`fsel.workflow.machine`. Neither allows reciprocals for quotients nor approximate functions, whose
digits differ between two makers of processors.
"""

from __future__ import annotations

import gc
import pickle
import time
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numba
from numba.core.caching import FunctionCache

from fsel.core.files import cache
from fsel.core.limits import WHEN_COMPILED

if TYPE_CHECKING:
    from filelock import FileLock

EXACT = {"nnan", "nsz"}  # no NaN, and no sign of zero: least and largest of two in one instruction
REORDERED = {"reassoc", "contract"}
PART = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}  # no entry from Python
COMPILED = "compiled"  # folder of the user's cache
INSTALLED = {"site-packages", "dist-packages"} & {*Path(__file__).parts}
LONGEST = 60.0  # seconds that one process waits for another that compiles


@lru_cache
def _lock(file: Path) -> FileLock:
    """Return the one lock of a file: a function that is compiled within another has it already."""
    from filelock import FileLock  # here: most processes compile nothing

    # where only soft locks work, one takes a file that another kind left for held
    return FileLock(file.with_suffix(f".{FileLock.__name__}"), LONGEST)


class SharedCache(FunctionCache):
    """The stored code of a function, to which one process at a time adds: another waits, and finds
    what it would have compiled too."""

    def __init__(self, function: Any, lock: Path) -> None:
        super().__init__(function)
        self._file, self._began = lock, 0.0

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return what is stored for a signature; None where it is to be compiled."""
        found = self._found(signature, target)
        if found is None:
            if not gc.get_freeze_count():  # a tenth of the time looks at what was imported before
                gc.freeze()
            with suppress(OSError):  # waited too long, or a folder that nobody may write to
                self._file.parent.mkdir(parents=True, exist_ok=True)
                _lock(self._file).acquire()
            found, self._began = self._found(signature, target), time.perf_counter()
            if found is not None:
                _lock(self._file).release()
        return found

    def _found(self, signature: Any, target: Any) -> Any:
        """Return what is stored; what a full disk or a power cut has damaged is stored anew."""
        try:
            return super().load_overload(signature, target)
        except (EOFError, pickle.UnpicklingError):
            self.flush()
            return None

    def save_overload(self, signature: Any, data: Any) -> None:
        """Store what was compiled, and tell those who listen."""
        with suppress(OSError):  # a full disk: what was compiled serves this process
            super().save_overload(signature, data)
        _lock(self._file).release()
        for tell in WHEN_COMPILED:
            tell(time.perf_counter() - self._began)


def _stored(**options: Any) -> Any:
    """Return a decorator that compiles and stores, of an installed package in the user's cache: pip
    would leave what lies beside the sources."""

    def compiled(function: Any) -> Any:
        stated = numba.config.CACHE_DIR
        if INSTALLED:
            numba.config.CACHE_DIR = stated or str(cache() / COMPILED)
        try:
            made = numba.njit(nogil=True, no_cfunc_wrapper=True, **options)(function)
            folder = Path(numba.config.CACHE_DIR or Path(__file__).parent / "__pycache__")
            made._cache = SharedCache(function, folder / f"{function.__module__}.lock")
        finally:
            numba.config.CACHE_DIR = stated
        return made

    return compiled


plain = _stored()
"""Compile a function as Python has it: a division by zero raises an error."""

exact = _stored(error_model="numpy", fastmath=EXACT)
"""Compile a function whose operations round as they are written; 1 / 0 is infinite."""

reordered = _stored(error_model="numpy", fastmath=REORDERED)
"""Compile a function whose sums may be taken in any order, and fused with products."""

exact_part = numba.njit(error_model="numpy", fastmath=EXACT, **PART)
"""As `exact`, of a function that others call, never Python."""

reordered_part = numba.njit(error_model="numpy", fastmath=REORDERED, **PART)
"""As `reordered`, of a function that others call, never Python."""

inlined = numba.njit(inline="always", nogil=True, error_model="numpy")
"""Paste a function into the compiled ones that call it: it is compiled as they are."""
