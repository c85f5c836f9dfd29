"""Two ways to compile a function with numba.

The order in which sums are fastest depends on the processor, and with it their last digits. Values
that are cut to an integer, compared or ranked are computed by functions that `exact` compiles; sums
that are results in themselves may be `reordered`: equal bytes on equal instructions, see
`fsel.workflow.machine`. Neither allows reciprocals for quotients nor approximate functions, whose
digits differ between two makers of processors.
"""

from __future__ import annotations

import numba

EXACT = {"nnan", "nsz"}  # no NaN, and no sign of zero: least and largest of two in one instruction
REORDERED = {"reassoc", "contract"}

exact = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=EXACT)
"""Compile a function whose operations round as they are written; 1 / 0 is infinite."""

reordered = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=REORDERED)
"""Compile a function whose sums may be taken in any order, and fused with products."""

inlined = numba.njit(inline="always", nogil=True, error_model="numpy")
"""Paste a function into the compiled ones that call it: it is compiled as they are."""
