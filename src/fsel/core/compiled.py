"""Two ways to compile a function with numba.

The sum of floating-point numbers depends on their order, and the order that is fastest depends on
the processor. A value that is cut to an integer, compared or ranked may then turn out another way.
Functions with such values are compiled by `exact`: every operation rounds as IEEE 754 says, in the
order that the source states, on every processor. Functions whose sums are results in themselves may
be compiled by `reordered`, where vectors pay: they give equal bytes where they are compiled for the
same instructions, see `fsel.workflow.machine`.

Neither allows reciprocals in place of quotients nor approximate functions: those begin with an
estimate, which processors of two makers return with different digits.
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
