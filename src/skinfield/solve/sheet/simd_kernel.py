"""SIMD addition of products of profiles to a field, which Numba does not make fast by itself.

The compiler cannot know that the field and the profiles do not overlap in memory, so it reads the
profiles again in every row. Here they are loaded once, into registers.
"""

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from skinfield.solve.sheet.response import GROUP, LANES


def _add_block(
    typing_context: Any,
    out: Any,
    start: Any,
    columns: Any,
    across: Any,
    first: Any,
    width: Any,
    down: Any,
    begin: Any,
    rows: Any,
) -> Any:
    """Add to a block of `LANES` columns and some rows of a flat field, from its cell `start` on.

    out[start + columns * row + cell] += sum over part of down[begin + GROUP * row + part] *
    across[first + width * part + cell]. Nothing is checked: the block must lie in the field.
    """
    whole = types.intp
    signature = types.void(out, whole, whole, across, whole, whole, down, whole, whole)

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        field, start, columns, profiles, first, width, heights, begin, rows = given
        field, profiles, heights = (
            context.make_array(kind)(context, builder, value).data
            for kind, value in ((out, field), (across, profiles), (down, heights))
        )
        vector = ir.VectorType(context.get_value_type(out.dtype), LANES)
        size = out.dtype.bitwidth // 8

        def place(base: Any, index: Any) -> Any:
            return builder.bitcast(builder.gep(base, [index]), vector.as_pointer())

        def spread(value: Any) -> Any:
            index = ir.IntType(32)
            first = ir.Constant(ir.VectorType(index, LANES), [0] * LANES)
            lanes = ir.Constant(vector, ir.Undefined)
            lanes = builder.insert_element(lanes, value, index(0))
            return builder.shuffle_vector(lanes, lanes, first)

        profile = []
        for _ in range(GROUP):
            profile.append(builder.load(place(profiles, first), align=size))
            first = builder.add(first, width)
        with cgutils.for_range(builder, rows) as loop:
            to = place(field, builder.add(start, builder.mul(loop.index, columns)))
            total = builder.load(to, align=size)
            at = builder.add(begin, builder.mul(loop.index, cgutils.intp_t(GROUP)))
            for part in range(GROUP):
                index = builder.add(at, cgutils.intp_t(part))
                height = spread(builder.load(builder.gep(heights, [index])))
                product = builder.fmul(height, profile[part], flags=("contract",))
                total = builder.fadd(total, product, flags=("contract",))
            builder.store(total, to, align=size)
        return context.get_dummy_value()

    return signature, generate


add_block: Any = intrinsic(_add_block)
