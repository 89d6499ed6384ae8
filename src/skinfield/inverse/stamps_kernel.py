"""Windows of cells times numbers, in the vectors of the machine at hand.

Numba leaves loops over the short rows of a window scalar, which costs 6 to 20 times what the
machine needs. So the two inner operations, `add_window` and `dot_window`, state their vectors
themselves. A row is taken in blocks of 16, 8 and 4 numbers and single ones for the rest; LLVM makes
of a block what the machine has: one register of AVX-512, two of AVX2, four of SSE or NEON.

`windows` (L, 4) int32 holds first row, first column, rows and columns of each window, `starts` (L,)
int32 where its numbers begin in `values`: row by row, without gaps. Nothing checks here that the
windows lie on the grid; `Stamps` does.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.core.errors import TypingError as TypingError
from numba.extending import intrinsic
from numpy.typing import NDArray

Numbers = NDArray[Any]
Ints32 = NDArray[np.int32]
WIDEST = 16  # numbers at once
NARROWER = (8, 4)
FAST = ("contract", "nsz")  # multiply and add in one rounding; NaN stays NaN
INDEX = types.intp


def _inlined(function: Callable[..., Any]) -> Any:
    """Make a function of types and instructions one that compiled code calls, at no cost."""
    return intrinsic(function)


@_inlined
def add_window(
    typing: Any,
    values: Any,
    start: Any,
    field: Any,
    first: Any,
    rows: Any,
    columns: Any,
    pitch: Any,
    factor: Any,
) -> Any:
    """Add `factor` times a window to the field.

    `values` (S,) holds the window from `start` on, `rows` x `columns`; `first` is its first cell
    of `field` (K,), `pitch` the cells of one row of the field.
    """
    _check(values, field)
    signature = types.void(values, INDEX, field, INDEX, INDEX, INDEX, INDEX, values.dtype)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        stamp, start, cells, first, rows, columns, pitch, factor = arguments
        stamp = context.make_array(signature.args[0])(context, builder, stamp).data
        cells = context.make_array(signature.args[2])(context, builder, cells).data
        everywhere = {lanes: _repeat(builder, factor, lanes) for lanes in (WIDEST, *NARROWER, 1)}
        for at, cell, lanes in _blocks(builder, start, first, rows, columns, pitch):
            here = _pointer(builder, stamp, at, lanes)
            there = _pointer(builder, cells, cell, lanes)
            align = _bytes(factor.type)
            added = builder.fmul(builder.load(here, align=align), everywhere[lanes], flags=FAST)
            total = builder.fadd(builder.load(there, align=align), added, flags=FAST)
            builder.store(total, there, align=align)
        return context.get_dummy_value()

    return signature, generate


@_inlined
def dot_window(
    typing: Any,
    values: Any,
    start: Any,
    field: Any,
    first: Any,
    rows: Any,
    columns: Any,
    pitch: Any,
) -> Any:
    """Sum of a window times the field; arguments as of `add_window`."""
    _check(values, field)
    signature = values.dtype(values, INDEX, field, INDEX, INDEX, INDEX, INDEX)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        stamp, start, cells, first, rows, columns, pitch = arguments
        stamp = context.make_array(signature.args[0])(context, builder, stamp).data
        cells = context.make_array(signature.args[2])(context, builder, cells).data
        element = context.get_value_type(signature.return_type)
        totals = {
            lanes: _zero(builder, _vector(element, lanes)) for lanes in (WIDEST, *NARROWER, 1)
        }
        align = _bytes(element)
        for at, cell, lanes in _blocks(builder, start, first, rows, columns, pitch):
            mine = builder.load(_pointer(builder, stamp, at, lanes), align=align)
            theirs = builder.load(_pointer(builder, cells, cell, lanes), align=align)
            product = builder.fmul(mine, theirs, flags=FAST)
            so_far = builder.load(totals[lanes])
            builder.store(builder.fadd(so_far, product, flags=FAST), totals[lanes])
        return _sum(builder, {lanes: builder.load(total) for lanes, total in totals.items()})

    return signature, generate


@_inlined
def alike(typing: Any, values: Any, other: Any) -> Any:
    """Refuse to compile for arrays of two types, or with gaps."""
    _check(values, other)
    return types.void(values, other), lambda context, *_: context.get_dummy_value()


@njit(cache=True, nogil=True)
def stamp_apply(
    values: Numbers, starts: Ints32, windows: Ints32, pitch: int, factors: Numbers, out: Numbers
) -> None:
    """Sum of all windows, each times its factor (L,): `out` (K,)."""
    out[:] = 0.0
    for taxel in range(len(starts)):
        row, column, rows, columns = windows[taxel]
        first = row * pitch + column
        add_window(values, starts[taxel], out, first, rows, columns, pitch, factors[taxel])


@njit(cache=True, nogil=True)
def stamp_adjoint(
    values: Numbers, starts: Ints32, windows: Ints32, pitch: int, field: Numbers, out: Numbers
) -> None:
    """Each window times what it covers of `field` (K,): `out` (L,)."""
    for taxel in range(len(starts)):
        row, column, rows, columns = windows[taxel]
        first = row * pitch + column
        out[taxel] = dot_window(values, starts[taxel], field, first, rows, columns, pitch)


@njit(cache=True, nogil=True)
def checked_apply(
    values: Numbers,
    starts: Ints32,
    windows: Ints32,
    shape: tuple[int, int],
    factors: Numbers,
    out: Numbers,
) -> bool:
    """`stamp_apply`, or False where the lengths do not fit."""
    alike(values, factors)
    if len(factors) != len(starts) or len(out) != shape[0] * shape[1]:
        return False
    stamp_apply(values, starts, windows, shape[1], factors, out)
    return True


@njit(cache=True, nogil=True)
def checked_adjoint(
    values: Numbers,
    starts: Ints32,
    windows: Ints32,
    shape: tuple[int, int],
    field: Numbers,
    out: Numbers,
) -> bool:
    """`stamp_adjoint`, or False where the lengths do not fit."""
    alike(values, out)
    if len(out) != len(starts) or len(field) != shape[0] * shape[1]:
        return False
    stamp_adjoint(values, starts, windows, shape[1], field, out)
    return True


@njit(cache=True, nogil=True)
def checked_apply_many(
    values: Numbers,
    starts: Ints32,
    windows: Ints32,
    shape: tuple[int, int],
    factors: Numbers,
    out: Numbers,
) -> bool:
    """`checked_apply` of each row of `factors` (P, L) into the row of `out` (P, K)."""
    fits = len(factors) == len(out)
    for patch in range(min(len(factors), len(out))):
        fits = fits and checked_apply(values, starts, windows, shape, factors[patch], out[patch])
    return fits


@njit(cache=True, nogil=True)
def checked_adjoint_many(
    values: Numbers,
    starts: Ints32,
    windows: Ints32,
    shape: tuple[int, int],
    fields: Numbers,
    out: Numbers,
) -> bool:
    """`checked_adjoint` of each row of `fields` (P, K) into the row of `out` (P, L)."""
    fits = len(fields) == len(out)
    for patch in range(min(len(fields), len(out))):
        fits = fits and checked_adjoint(values, starts, windows, shape, fields[patch], out[patch])
    return fits


def _blocks(
    builder: Any, start: Any, first: Any, rows: Any, columns: Any, pitch: Any
) -> Iterator[tuple[Any, Any, int]]:
    """Code that goes through all blocks: number of the stamp, cell of the field, length."""
    index = columns.type
    with cgutils.for_range(builder, rows) as row:
        at = builder.add(start, builder.mul(row.index, columns))
        cell = builder.add(first, builder.mul(row.index, pitch))
        with cgutils.for_range(builder, builder.lshr(columns, index(4))) as block:
            shift = builder.shl(block.index, index(4))
            yield builder.add(at, shift), builder.add(cell, shift), WIDEST
        for lanes in NARROWER:
            left = builder.icmp_unsigned("!=", builder.and_(columns, index(lanes)), index(0))
            with builder.if_then(left):
                shift = builder.and_(columns, index(-2 * lanes))
                yield builder.add(at, shift), builder.add(cell, shift), lanes
        with cgutils.for_range(builder, builder.and_(columns, index(3))) as single:
            shift = builder.add(builder.and_(columns, index(-4)), single.index)
            yield builder.add(at, shift), builder.add(cell, shift), 1


def _check(values: Any, field: Any) -> None:
    """Refuse to compile for arrays of two types, or with gaps."""
    kinds = {
        (getattr(kind, "dtype", kind), getattr(kind, "layout", "")) for kind in (values, field)
    }
    if kinds != {(values.dtype, "C")}:
        raise TypingError(f"{values} and {field} are not contiguous arrays of one type")


def _vector(element: Any, lanes: int) -> Any:
    return element if lanes == 1 else ir.VectorType(element, lanes)


def _zero(builder: Any, kind: Any) -> Any:
    """Place of a sum, which LLVM keeps in a register."""
    place = cgutils.alloca_once(builder, kind)  # type: ignore[no-untyped-call]
    builder.store(kind(0.0 if isinstance(kind, (ir.FloatType, ir.DoubleType)) else None), place)
    return place


def _bytes(element: Any) -> int:
    return 4 if isinstance(element, ir.FloatType) else 8


def _pointer(builder: Any, data: Any, at: Any, lanes: int) -> Any:
    place = builder.gep(data, [at])
    return builder.bitcast(place, _vector(data.type.pointee, lanes).as_pointer())


def _repeat(builder: Any, number: Any, lanes: int) -> Any:
    """Vector of one number."""
    if lanes == 1:
        return number
    empty = ir.Constant(ir.VectorType(number.type, lanes), ir.Undefined)
    first = builder.insert_element(empty, number, ir.IntType(32)(0))
    return builder.shuffle_vector(first, empty, _pick([0] * lanes))


def _pick(lanes: list[int]) -> Any:
    return ir.Constant(ir.VectorType(ir.IntType(32), len(lanes)), lanes)


def _sum(builder: Any, totals: dict[int, Any]) -> Any:
    """Sum of vectors of 16, 8 and 4 numbers and one number, folded in halves."""
    folded, lanes = totals[WIDEST], WIDEST
    while lanes > 1:
        lanes //= 2
        low = builder.shuffle_vector(folded, folded, _pick(list(range(lanes))))
        high = builder.shuffle_vector(folded, folded, _pick(list(range(lanes, 2 * lanes))))
        folded = builder.fadd(low, high, flags=FAST)
        if lanes in totals and lanes > 1:
            folded = builder.fadd(folded, totals[lanes], flags=FAST)
    single = builder.extract_element(folded, ir.IntType(32)(0))
    return builder.fadd(single, totals[1], flags=FAST)
