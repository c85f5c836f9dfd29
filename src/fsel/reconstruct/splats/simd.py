"""A vector of four float32 in one instruction, for loops that Numba leaves scalar.

Numba unrolls loops of four before its vectoriser sees them, and pairs no scalars into vectors.
"""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

FOUR = ir.VectorType(ir.FloatType(), 4)
LANES = ir.VectorType(ir.IntType(32), 4)


@intrinsic
def add_scaled(typing_context, total, at, scale, values, start):
    """`total[at : at + 4] += scale * values[start : start + 4]`, inside compiled functions.

    Bounds are not checked.

    Args:
        total, values: flat contiguous float32 arrays.
        at, start: integers.
        scale: float32.
    """
    signature = types.void(total, at, scale, values, start)

    def generate(context, builder, signature, given):
        def four(array, offset):
            made = context.make_array(signature.args[array])(context, builder, given[array])
            return builder.bitcast(builder.gep(made.data, [given[offset]]), FOUR.as_pointer())

        target, nothing = four(0, 1), ir.Constant(FOUR, ir.Undefined)
        first = builder.insert_element(nothing, given[2], ir.Constant(ir.IntType(32), 0))
        factor = builder.shuffle_vector(first, nothing, ir.Constant(LANES, [0] * 4))
        product = builder.fmul(builder.load(four(3, 4), align=4), factor)
        summed = builder.fadd(builder.load(target, align=4), product)
        builder.store(summed, target, align=4)
        return context.get_dummy_value()

    return signature, generate
