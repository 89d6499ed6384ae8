"""Named tuples of arrays as one pointer: what many arrays cost compiled functions as arguments.

A compiled function takes each array of a named tuple as seven arguments: a call from Python with
sixty arrays lasts 10 µs, and functions that call each other with them compile for minutes. Packed,
all is a table of numbers and addresses, of which compiled code reads what it needs when it does.
"""

from collections.abc import MutableMapping
from typing import Any
from weakref import WeakValueDictionary

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, intrinsic, lower_getattr_generic, register_model
from numba.np import arrayobj
from numpy.typing import NDArray

from skinfield.compiled import MODE
from skinfield.errors import Ints

WORD: Any = ir.IntType(64)
NUMBA: Any = numba
ARRAYS: Any = arrayobj
MODELS: Any = models
PACK: Any = cgutils
lowered: Any = lower_getattr_generic


class PackedType(types.Type):
    """Numba's type of a packed named tuple.

    Parameters
    ----------
    example : named tuple
        Of arrays, numbers, and named tuples of the like; sizes may differ.

    Attributes
    ----------
    fields : dict
        Type and place in the table of each field.
    size : int
        Words of the table.
    """

    def __init__(self, example: Any) -> None:
        self.fields: dict[str, tuple[Any, int]] = {}
        self.size = 0
        for name, value in zip(example._fields, example, strict=True):
            its = type_of(value)
            self.fields[name] = its, self.size
            words = 1 + its.ndim if isinstance(its, types.Array) else getattr(its, "size", 1)
            self.size += words
        described = ", ".join(f"{name}: {its}" for name, (its, _) in self.fields.items())
        super().__init__(f"Packed({described})")


def type_of(value: Any) -> Any:
    """Numba's type of a field."""
    if hasattr(value, "_fields"):
        return PackedType(value)
    if isinstance(value, np.ndarray):
        return NUMBA.typeof(value)
    return types.float64 if isinstance(value, float) else types.int64


class Packed:
    """Table of a named tuple.

    Parameters
    ----------
    value : named tuple
    its : PackedType

    Attributes
    ----------
    address : int
        Of the table, as long as this lives.

    Raises
    ------
    TypeError
        For an array of another kind than that of the type.
    """

    def __init__(self, value: Any, its: PackedType) -> None:
        self.value, self.its = value, its
        self._table = np.zeros(its.size, np.int64)
        _fill(self._table, value, its)
        self.address = int(self._table.ctypes.data)
        PACKED[self.address] = self

    def put(self, name: str, part: Any) -> None:
        """Take another named tuple for one that is a field; the address stays."""
        kind, at = self.its.fields[name]
        self.value = self.value._replace(**{name: part})
        _fill(self._table[at : at + kind.size], part, kind)

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy has arrays elsewhere."""
        return Packed, (self.value, self.its)


PACKED: MutableMapping[int, Packed] = WeakValueDictionary()  # those alive, by address


def _fill(table: Ints, value: Any, its: PackedType) -> None:
    for name, part in zip(value._fields, value, strict=True):
        kind, at = its.fields[name]
        if isinstance(kind, PackedType):
            _fill(table[at : at + kind.size], part, kind)
        elif isinstance(kind, types.Array):
            _check(name, part, kind)
            table[at], table[at + 1 : at + 1 + part.ndim] = part.ctypes.data, part.shape
        elif kind == types.float64:
            table.view(np.float64)[at] = part
        else:
            table[at] = part


def _check(name: str, part: NDArray[Any], kind: Any) -> None:
    if not NUMBA.typeof(part) == kind:
        raise TypeError(f"{name} is {NUMBA.typeof(part)}, expected {kind}")


def unpacking(its: PackedType) -> Any:
    """Compiled function from the address of a table to the named tuple."""
    if MODE.interpreted:
        return lambda address: PACKED[address].value

    @intrinsic
    def unpack(context: Any, address: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            return builder.inttoptr(values[0], WORD.as_pointer())

        return its(types.int64), generate

    return unpack


@register_model(PackedType)
class PackedModel(MODELS.PrimitiveModel):  # type: ignore[misc]
    """A pointer to the table."""

    def __init__(self, manager: Any, its: Any) -> None:
        super().__init__(manager, its, WORD.as_pointer())


@infer_getattr
class PackedFields(AttributeTemplate):
    """Types of fields."""

    key = PackedType

    def generic_resolve(self, its: PackedType, name: str) -> Any:  # type: ignore[override]
        """Of one of them; None if there is none such."""
        return its.fields[name][0] if name in its.fields else None


@lowered(PackedType)  # type: ignore[untyped-decorator]
def read_field(context: Any, builder: Any, its: PackedType, table: Any, name: str) -> Any:
    """Code that reads a field."""
    kind, at = its.fields[name]

    def word(k: int) -> Any:
        return builder.load(builder.gep(table, [ir.Constant(WORD, at + k)]))

    if isinstance(kind, PackedType):
        return builder.gep(table, [ir.Constant(WORD, at)])
    if kind == types.float64:
        return builder.bitcast(word(0), ir.DoubleType())
    if not isinstance(kind, types.Array):
        return word(0)
    array = ARRAYS.make_array(kind)(context, builder)
    size = context.get_abi_sizeof(context.get_data_type(kind.dtype))
    shape, strides, step = [word(1 + k) for k in range(kind.ndim)], [], ir.Constant(WORD, size)
    for length in reversed(shape):
        strides.append(step)
        step = builder.mul(step, length)
    data = builder.inttoptr(word(0), array.data.type)
    ARRAYS.populate_array(
        array,
        data=data,
        shape=PACK.pack_array(builder, shape),
        strides=PACK.pack_array(builder, strides[::-1]),
        itemsize=ir.Constant(WORD, size),
        meminfo=None,
    )
    return array._getvalue()
