"""Exponential in compiled loops: LLVM makes the standard one a call, which keeps a loop scalar."""

from __future__ import annotations

import math

import numpy as np
from numba import types
from numba.extending import overload

from fsel.core.compiled import EXACT

# 2^f for f from -1/2 to 1/2, to 8e-8 of the value
POWERS = (1.00000007, 0.69314695, 0.24022122, 0.05550743, 0.00967546, 0.0013267)


def exponential(x):
    """Compute exp(x) for x of -87 to 87: exact for float64; for float32 to 1e-6, in vectors."""
    return math.exp(x)


@overload(exponential, jit_options={"fastmath": EXACT})
def _exponential(x):
    if x == types.float32:
        f, i = np.float32, np.int32
        c0, c1, c2, c3, c4, c5 = (np.float32(c) for c in POWERS)
        binary, half = np.float32(math.log2(math.e)), np.float32(0.5)

        def short(x):
            y = x * binary
            whole = np.floor(y + half)
            g = y - whole
            power = ((((c5 * g + c4) * g + c3) * g + c2) * g + c1) * g + c0
            # the exponent's bits of a float32
            return power * i((i(whole) + i(127)) << i(23)).view(f)

        return short
    return lambda x: math.exp(x)
