"""Four values at once, such as a pixel's channels, for loops that Numba leaves scalar.

The functions work on flat contiguous arrays of one float type, inside compiled functions; bounds
are not checked.
"""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

LANES = 4
CORNERS = 8
WHOLE = ir.IntType(64)


class _Code:
    """Instructions on the arguments of one call."""

    def __init__(self, context, builder, signature, given):
        self.builder = builder
        self.arrays = {}
        for at, kind in enumerate(signature.args):
            if isinstance(kind, types.Array):
                made = context.make_array(kind)(context, builder, given[at])
                self.arrays[at] = made.data
        self.given = given
        scalar = context.get_value_type(signature.args[0].dtype)
        self.vector = ir.VectorType(scalar, LANES)
        self.bytes = 4 if scalar == ir.FloatType() else 8

    def place(self, array, offset):
        """Return a pointer to where four values of an array begin."""
        start = self.builder.gep(self.arrays[array], [offset])
        return self.builder.bitcast(start, self.vector.as_pointer())

    def load(self, array, offset):
        return self.builder.load(self.place(array, offset), align=self.bytes)

    def store(self, value, array, offset):
        self.builder.store(value, self.place(array, offset), align=self.bytes)

    def corner(self, rows, shares, sample, corner, width, at):
        """Return the offset of one vertex's four values, and its share in all four lanes."""
        build = self.builder
        spot = build.add(build.mul(sample, WHOLE(CORNERS)), WHOLE(corner))
        row = build.sext(build.load(build.gep(self.arrays[rows], [spot])), WHOLE)
        share = build.load(build.gep(self.arrays[shares], [spot]))
        return build.add(build.mul(row, width), at), self.spread(share)

    def spread(self, value):
        """Return a value in all four lanes."""
        empty = ir.Constant(self.vector, ir.Undefined)
        first = self.builder.insert_element(empty, value, ir.IntType(32)(0))
        zeros = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
        return self.builder.shuffle_vector(first, empty, zeros)


@intrinsic
def add_scaled(typing_context, total, at, scale, values, start):
    """`total[at : at + 4] += scale * values[start : start + 4]`; product and sum round apart."""
    signature = types.void(total, at, scale, values, start)

    def generate(context, builder, signature, given):
        code = _Code(context, builder, signature, given)
        product = builder.fmul(code.load(3, given[4]), code.spread(given[2]))
        code.store(builder.fadd(code.load(0, given[1]), product), 0, given[1])
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def blend(typing_context, out, values, rows, shares, sample, width, at):
    """Write to `out[at : at + 4]` the weighted sum of four of the flat (n, width) values at the
    eight vertices of a sample, flat (S, 8) rows and shares."""
    signature = types.void(out, values, rows, shares, types.int64, types.int64, types.int64)

    def generate(context, builder, signature, given):
        code = _Code(context, builder, signature, given)
        sample, width, at = given[4:]
        total = ir.Constant(code.vector, [0.0] * LANES)
        for corner in range(CORNERS):
            offset, share = code.corner(2, 3, sample, corner, width, at)
            product = builder.fmul(code.load(1, offset), share, flags=["contract"])
            total = builder.fadd(total, product, flags=["contract"])
        code.store(total, 0, at)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def scatter(typing_context, out, values, rows, shares, sample, width, at):
    """Add `values[at : at + 4]`, weighted, to four values of a sample's eight vertices.

    `out` is flat (n, width), `values` (width,); the others are those of `blend`.
    """
    signature = types.void(out, values, rows, shares, types.int64, types.int64, types.int64)

    def generate(context, builder, signature, given):
        code = _Code(context, builder, signature, given)
        sample, width, at = given[4:]
        added = code.load(1, at)
        for corner in range(CORNERS):
            offset, share = code.corner(2, 3, sample, corner, width, at)
            product = builder.fmul(added, share, flags=["contract"])
            total = builder.fadd(code.load(0, offset), product, flags=["contract"])
            code.store(total, 0, offset)
        return context.get_dummy_value()

    return signature, generate
