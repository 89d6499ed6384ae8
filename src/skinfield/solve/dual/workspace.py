"""Workspace of the dual search: its arrays, prepared and lasting, the clock, and masked taxels."""

import sys
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints

Ints32 = NDArray[np.int32]
BY_TAXEL, BY_NODE, LISTS = 6, 4, 4  # arrays of `Memory` of one kind
COUNTS, ROOM = 8, 2  # numbers of two of its arrays


class Problem(NamedTuple):
    """What never changes; see `skinfield.solve.non_negative`."""

    rows: Floats
    norms: Floats
    penalty: Floats
    bump: Floats
    whitening: Floats
    stamps: Floats
    taxels: Ints32
    firsts: Ints32
    cells: Ints32
    dropped: Floats
    allowed: NDArray[np.bool_]
    threshold: float
    least: float
    tolerance: float
    rounding: float
    most: int
    height: int
    width: int


class Memory(NamedTuple):
    """What lasts from reading to reading, and room to work in."""

    target: Floats
    dual: Floats
    predicted: Floats
    ascent: Floats
    step: Floats
    scratch: Floats
    listed: Ints
    slack: Floats
    turn: Floats
    every: Floats
    active: Ints
    factored: Ints
    lower: Floats
    pressed: Ints
    amounts: Floats
    counts: Ints
    measures: Floats
    room: Ints


class Packed(NamedTuple):
    """Both in few arrays: each one that is handed to compiled code takes its time.

    Attributes
    ----------
    rows, whitening, stamps, allowed
        Of `Problem`.
    vectors : array
        Norms, penalty, bump, and what the stamps dropped, one after the other.
    places : int32 array
        Taxels, firsts and cells of the stamps.
    settings : (9,) array
        The numbers of `Problem`, then how many stamps and tiles there are.
    numbers : array
        Of `Memory`, by taxel, then by node, then `lower`.
    indices : int64 array
        Likewise.
    measures : (12,) array
    """

    rows: Floats
    vectors: Floats
    whitening: Floats
    stamps: Floats
    places: Ints32
    allowed: NDArray[np.bool_]
    settings: Floats
    numbers: Floats
    indices: Ints
    measures: Floats


def packed(problem: Problem, room: tuple[Floats, Ints, Floats]) -> Packed:
    """Hand over a problem with the room of `memory_in`."""
    vectors = (problem.norms, problem.penalty, problem.bump.ravel(), problem.dropped)
    settings = [*problem[Problem._fields.index("threshold") :], len(problem.stamps)]
    return Packed(
        problem.rows,
        np.concatenate(vectors),
        problem.whitening,
        problem.stamps,
        np.concatenate([problem.taxels, problem.firsts, problem.cells]),
        problem.allowed,
        np.array([*settings, len(problem.cells)], dtype=np.float64),
        *room,
    )


def room_for(nodes: int, width: int, kind: np.dtype[Any]) -> tuple[Floats, Ints, Floats]:
    """Numbers, indices and measures of one patch; pages that are never written are never taken."""
    numbers = np.zeros(BY_TAXEL * width + BY_NODE * nodes + width * width, dtype=kind)
    return numbers, np.zeros(LISTS * nodes + COUNTS + ROOM, dtype=np.int64), np.zeros(12)


def memory_in(nodes: int, width: int, room: tuple[Floats, Ints, Floats]) -> Memory:
    """Views of the room."""
    numbers, indices, measures = room
    by_taxel = numbers[: BY_TAXEL * width].reshape((BY_TAXEL, width))
    begin = BY_TAXEL * width
    by_node = numbers[begin : begin + BY_NODE * nodes].reshape((BY_NODE, nodes))
    lower = numbers[begin + BY_NODE * nodes :].reshape((width, width))
    lists = indices[: LISTS * nodes].reshape((LISTS, nodes))
    end = LISTS * nodes + COUNTS
    return Memory(
        by_taxel[0],
        by_taxel[1],
        by_taxel[2],
        by_taxel[3],
        by_taxel[4],
        by_taxel[5],
        lists[0],
        by_node[0],
        by_node[1],
        by_node[2],
        lists[1],
        lists[2],
        lower,
        lists[3],
        by_node[3],
        indices[LISTS * nodes : end],
        measures,
        indices[end:],
    )


memory_of_packed = inner(memory_in)


@inner
def unpacked(given: Packed) -> tuple[Problem, Memory]:
    """Problem and memory as views of what was handed over."""
    nodes, width = given.rows.shape
    settings, vectors, places = given.settings, given.vectors, given.places
    blocks, tiles = int(settings[7]), int(settings[8])
    kept = nodes if tiles > 0 else 0
    bumps = len(vectors) - 2 * nodes - kept
    side = int(np.round(np.sqrt(bumps)))
    firsts = tiles + 1 if tiles > 0 else 0
    problem = Problem(
        given.rows,
        vectors[:nodes],
        vectors[nodes : 2 * nodes],
        vectors[2 * nodes : 2 * nodes + bumps].reshape((side, side)),
        given.whitening,
        given.stamps,
        places[:blocks],
        places[blocks : blocks + firsts],
        places[blocks + firsts :],
        vectors[2 * nodes + bumps :],
        given.allowed,
        settings[0],
        settings[1],
        settings[2],
        settings[3],
        int(settings[4]),
        int(settings[5]),
        int(settings[6]),
    )
    room = (given.numbers, given.indices, given.measures)
    return problem, memory_of_packed(nodes, width, room)


MONOTONIC = 1  # of Linux: what `time.perf_counter` reads there
UPTIME_RAW = 8  # of macOS, likewise

if sys.platform == "win32":
    _ticks: Any = types.ExternalFunction("QueryPerformanceCounter", types.int32(types.voidptr))
    _rate: Any = types.ExternalFunction("QueryPerformanceFrequency", types.int32(types.voidptr))

    @njit
    def now_ns(room: Ints) -> int:
        """Time now; `room` (2,) int64 is where the system writes it."""
        _ticks(room.ctypes)
        ticks = room[0]
        _rate(room.ctypes)
        whole, part = ticks // room[0], ticks % room[0]
        return int(whole * 1_000_000_000 + part * 1_000_000_000 // room[0])

elif sys.platform == "darwin":
    _uptime: Any = types.ExternalFunction("clock_gettime_nsec_np", types.int64(types.int32))

    @njit
    def now_ns(room: Ints) -> int:
        """Time now; `room` is not needed on this system."""
        return int(_uptime(UPTIME_RAW))

else:
    _gettime: Any = types.ExternalFunction("clock_gettime", types.int32(types.int32, types.voidptr))

    @njit
    def now_ns(room: Ints) -> int:
        """Time now; `room` (2,) int64 is where the system writes it."""
        _gettime(MONOTONIC, room.ctypes)
        return int(room[0] * 1_000_000_000 + room[1])


@njit
def mask_taxels(
    whole: NDArray[Any],
    whole_norms: NDArray[Any],
    whole_penalty: NDArray[Any],
    valid: NDArray[np.bool_],
    rows: NDArray[Any],
    norms: NDArray[Any],
    penalty: NDArray[Any],
) -> None:
    """Copy `whole` (K, W) into `rows` with zeros for taxels that are not `valid` (L,).

    Lengths of the rows, and penalties in proportion to them, follow.
    """
    for node in range(len(whole)):
        square = 0.0
        for taxel in range(len(valid)):
            value = whole[node, taxel] if valid[taxel] else whole.dtype.type(0.0)
            rows[node, taxel] = value
            square += np.float64(value) * value
        norms[node] = np.sqrt(square)
        before = whole_norms[node]
        penalty[node] = whole_penalty[node] * (norms[node] / before) if before > 0.0 else 0.0
