"""Ways to compile a function with numba.

The order in which sums are fastest depends on the processor, and with it their last digits. Values
that are cut to an integer, compared or ranked are computed by functions that `exact` compiles; sums
that are results in themselves may be `reordered`: equal bytes on equal instructions, see
`fsel.workflow.machine`. Neither allows reciprocals for quotients nor approximate functions, whose
digits differ between two makers of processors.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numba

from fsel.core.files import cache

EXACT = {"nnan", "nsz"}  # no NaN, and no sign of zero: least and largest of two in one instruction
REORDERED = {"reassoc", "contract"}
PART = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "forceinline": True}
COMPILED = "compiled"  # folder of the user's cache
INSTALLED = {"site-packages", "dist-packages"} & {*Path(__file__).parts}


def _stored(**options: Any) -> Any:
    """Return a decorator that compiles and stores, of an installed package in the user's cache: pip
    would leave what lies beside the sources."""

    def compiled(function: Any) -> Any:
        stated = numba.config.CACHE_DIR
        if INSTALLED:
            numba.config.CACHE_DIR = stated or str(cache() / COMPILED)
        try:
            return numba.njit(cache=True, nogil=True, **options)(function)
        finally:
            numba.config.CACHE_DIR = stated

    return compiled


plain = _stored()
"""Compile a function as Python has it: a division by zero raises an error."""

exact = _stored(error_model="numpy", fastmath=EXACT)
"""Compile a function whose operations round as they are written; 1 / 0 is infinite."""

reordered = _stored(error_model="numpy", fastmath=REORDERED)
"""Compile a function whose sums may be taken in any order, and fused with products."""

exact_part = numba.njit(error_model="numpy", fastmath=EXACT, **PART)
"""As `exact`, of a function that others call, never Python."""

inlined = numba.njit(inline="always", nogil=True, error_model="numpy")
"""Paste a function into the compiled ones that call it: it is compiled as they are."""
