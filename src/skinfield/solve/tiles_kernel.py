"""Tiles of 4 x 4 cells times numbers, in the vectors of the machine at hand.

Numba leaves loops over so few numbers scalar, which costs 6 to 20 times what the machine needs. So
the inner operations are written as instructions on vectors of 16 numbers, of which LLVM makes what
the machine has: one register of AVX-512, two of AVX2, four of SSE or NEON.

A block is one tile of one taxel, a row of `values` (B, 16). Blocks stand tile by tile: those of
tile t from `firsts[t]` to `firsts[t + 1]`, of the taxels in `taxels` (B,). The tile's first cell is
`cells[t]`; its four rows are `pitch` cells apart. Nothing here checks that tiles lie on the field;
`Tiles` makes them so.
"""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic
from numpy.typing import NDArray

from skinfield.compiled import MODE, njit

Numbers = NDArray[Any]
Ints32 = NDArray[np.int32]
INDEX = types.intp
FAST = ("contract", "nsz", "reassoc")  # sums in any order; NaN stays NaN
SIDE = 4  # cells
LANES = SIDE * SIDE
TOGETHER = 6  # patches for which a block is loaded once


def data(context: Any, builder: Any, arrays: Any) -> list[Any]:
    """Where the numbers are of some arrays, each with its type."""
    return [context.make_array(kind)(context, builder, array).data for kind, array in arrays]


def _index(builder: Any, array: Any, at: Any) -> Any:
    """A number of an int32 array, in the machine's own width."""
    return builder.sext(builder.load(builder.gep(array, [at])), at.type)


def place(builder: Any, array: Any, at: Any, lanes: int) -> Any:
    """Where a vector stands that begins at a number of an array."""
    vector = ir.VectorType(array.type.pointee, lanes)
    return builder.bitcast(builder.gep(array, [at]), vector.as_pointer())


def load(builder: Any, array: Any, at: Any, lanes: int) -> Any:
    """Some numbers from `at` on, which need not stand at a whole multiple of anything."""
    return builder.load(place(builder, array, at, lanes), align=size_of(array))


def size_of(array: Any) -> int:
    """Bytes of a number of an array."""
    return 4 if isinstance(array.type.pointee, ir.FloatType) else 8


def _choose(builder: Any, vector: Any, lanes: Sequence[int], other: Any = None) -> Any:
    numbers = ir.Constant(ir.VectorType(ir.IntType(32), len(lanes)), list(lanes))
    return builder.shuffle_vector(vector, vector if other is None else other, numbers)


def repeat(builder: Any, number: Any, lanes: int = LANES) -> Any:
    """Vector of one number."""
    empty = ir.Constant(ir.VectorType(number.type, lanes), ir.Undefined)
    return _choose(builder, builder.insert_element(empty, number, ir.IntType(32)(0)), [0] * lanes)


def _zeros(builder: Any, array: Any) -> Any:
    """Place of a sum, which LLVM keeps in a register."""
    vector = ir.VectorType(array.type.pointee, LANES)
    place = cgutils.alloca_once(builder, vector)  # type: ignore[no-untyped-call]
    builder.store(ir.Constant(vector, None), place)
    return place


def _add_product(builder: Any, total: Any, one: Any, other: Any) -> None:
    product = builder.fmul(one, other, flags=FAST)
    builder.store(builder.fadd(builder.load(total), product, flags=FAST), total)


def _check(values: Any, *others: Any) -> None:
    kinds = {(getattr(kind, "dtype", kind), getattr(kind, "layout", "")) for kind in others}
    if kinds != {(values.dtype, "C")} or values.layout != "C":
        raise TypingError(f"{values} and {others} are not contiguous arrays of one type")


def _tile_product(patches: int) -> Any:
    """Code that adds one tile of the product to the fields of some patches."""

    def add_tile(
        typing: Any,
        values: Any,
        taxels: Any,
        factors: Any,
        out: Any,
        start: Any,
        cell: Any,
        begin: Any,
        end: Any,
        sizes: Any,
    ) -> Any:
        _check(values, factors, out)

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            first = zip(signature.args[:4], arguments[:4], strict=True)
            stamp, listed, given, field = data(context, builder, first)
            start, cell, begin, end, sizes = arguments[4:]
            pitch, inputs, outputs = (builder.extract_value(sizes, i) for i in range(3))
            index = begin.type
            chains = 2 if patches == 1 else 1  # sums that need not wait for each other
            totals = [_zeros(builder, stamp) for _ in range(patches * chains)]

            def add_block(block: Any, chain: int) -> None:
                numbers = load(builder, stamp, builder.mul(block, index(LANES)), LANES)
                taxel = builder.add(builder.mul(start, inputs), _index(builder, listed, block))
                for patch in range(patches):
                    at = builder.add(taxel, builder.mul(index(patch), inputs))
                    factor = repeat(builder, builder.load(builder.gep(given, [at])))
                    _add_product(builder, totals[patch + chain], numbers, factor)

            count = builder.sub(end, begin)
            with cgutils.for_range(builder, builder.udiv(count, index(chains))) as loop:
                block = builder.add(begin, builder.mul(loop.index, index(chains)))
                for chain in range(chains):
                    add_block(builder.add(block, index(chain)), chain)
            with cgutils.for_range(builder, builder.urem(count, index(chains))):
                add_block(builder.sub(end, index(1)), 0)
            if chains > 1:
                total = builder.fadd(*(builder.load(total) for total in totals), flags=FAST)
                builder.store(total, totals[0])
            for patch in range(patches):
                at = builder.mul(builder.add(start, index(patch)), outputs)
                corner = builder.add(at, cell)
                _add_rows(builder, builder.load(totals[patch]), field, corner, pitch)
            return context.get_dummy_value()

        sizes_type = types.UniTuple(INDEX, 3)  # type: ignore[no-untyped-call]
        arrays = values, taxels, factors, out
        return types.void(*arrays, INDEX, INDEX, INDEX, INDEX, sizes_type), generate

    return partial(_add_tile, patches) if MODE.interpreted else intrinsic(add_tile)


def _add_tile(
    patches: int,
    values: Numbers,
    taxels: Ints32,
    factors: Numbers,
    out: Numbers,
    start: int,
    cell: int,
    begin: int,
    end: int,
    sizes: tuple[int, int, int],
) -> None:
    """The same, interpreted."""
    pitch, inputs, outputs = sizes
    for patch in range(start, start + patches):
        given = factors.reshape(-1)[patch * inputs + taxels[begin:end]]
        tile = given @ values.reshape(-1, LANES)[begin:end]
        at = patch * outputs + cell + pitch * np.arange(SIDE)[:, None] + np.arange(SIDE)
        out.reshape(-1)[at] += tile.reshape(SIDE, SIDE)


def _add_rows(builder: Any, tile: Any, field: Any, corner: Any, pitch: Any) -> None:
    for row in range(SIDE):
        at = builder.add(corner, builder.mul(pitch, pitch.type(row)))
        part = _choose(builder, tile, range(SIDE * row, SIDE * (row + 1)))
        total = builder.fadd(load(builder, field, at, SIDE), part)
        builder.store(total, place(builder, field, at, SIDE), align=size_of(field))


add_tile, add_tiles = _tile_product(1), _tile_product(TOGETHER)


@njit
def apply_tiles(
    values: Numbers,
    taxels: Ints32,
    firsts: Ints32,
    cells: Ints32,
    pitch: int,
    factors: Numbers,
    out: Numbers,
) -> None:
    """Sum of all blocks, each times its taxel's factor: (P, L) into `out` (P, K), row by row."""
    out[:] = 0.0
    patches, inputs = factors.shape
    sizes = (pitch, inputs, out.shape[1])
    whole = patches - patches % TOGETHER
    for start in range(0, whole, TOGETHER):
        for tile in range(len(cells)):
            begin, end = firsts[tile], firsts[tile + 1]
            add_tiles(values, taxels, factors, out, start, cells[tile], begin, end, sizes)
    for start in range(whole, patches):
        for tile in range(len(cells)):
            begin, end = firsts[tile], firsts[tile + 1]
            add_tile(values, taxels, factors, out, start, cells[tile], begin, end, sizes)
