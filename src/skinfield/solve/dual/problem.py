"""Problem of the dual search and the memory of its steps: the arrays that compiled code works on.

All in whitened units, as in `NonNegative`. K nodes, L taxels; their number filled up with zeros to
W, whole vector registers.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import njit
from skinfield.errors import Floats, Ints

NORM, DROPPED, SHARED = range(3)  # rows of `Problem.nodes`
THRESHOLD, PENALTY, TOLERANCE, ROUNDING, MOST, HEIGHT, WIDTH, MISFIT = range(8)  # of `numbers`
TARGET, DUAL, PREDICTED, ASCENT, STEP, SCRATCH, LOWER = range(7)  # rows of `Memory.taxels`
SLACK, TURN, EVERY, AMOUNT = range(4)  # rows of `Memory.nodes`
LISTED, ACTIVE, FACTORED, PRESSED, ALL, COUNTS = range(6)  # rows of `Memory.lists`
CLOCK, IDLE, SEARCHED, STEPS, PRESSING, STARTED, FACTORS = 0, 2, 3, 4, 5, 6, 7  # of row `COUNTS`
COUNTED = 8
GAP, OBJECTIVE, STEP_PACE, PASS_PACE, SPREAD_PACE, UNSOLVED, TYPICAL = range(7)  # of `measures`


def whitened(
    rows: NDArray[Any], offset: Floats
) -> tuple[NDArray[Any], Floats, NDArray[Any], NDArray[Any]]:
    """Rows B (K, W) of independent noise for that with an offset o (W,) that taxels share.

    (1 + o o')^-1 is the square of 1 - s s', with s along o and |s|^2 = 1 - (1 + |o|^2)^-1/2.

    Returns
    -------
    rows, root, norms, shared : (K, W), (W,), (K,) and (K,) arrays
        B - (B s) s', s, the norms of these rows, and B s.
    """
    root = root_of(offset)
    shared = rows @ root
    rows = rows - np.outer(shared, root)
    return rows, root, np.linalg.norm(rows, axis=1), shared


def root_of(offset: Floats) -> Floats:
    """Vector s (W,) of an offset o; see `whitened`."""
    square = float(offset @ offset)
    size = np.sqrt((1.0 - 1.0 / np.sqrt(1.0 + square)) / max(square, 1e-300))
    return np.asarray(offset * size)


class DualProblem(NamedTuple):
    """What never changes.

    Attributes
    ----------
    rows : (K, W) array
        What each node's bump does to the taxels, whitened: B - (B s) s'.
    nodes : (3, K) array
        Of each node: norm of its row, norm of what the stamps lack of it, and B s.
    whitening : (L,) float64 array, per unit of the reading
        0 for a taxel that is left out.
    offset, root : (W,) float64 arrays
        Deviation of the offset that taxels share, in each taxel's noise, and s; see `whitened`.
    bump : (2 n + 1, 2 n + 1) array, Pa
    stamps : (B, 16) array
        Blocks of `Tiles` of B, by which all nodes are seen; none where that does not pay.
    places : int32 array
        The blocks' `taxels`, `firsts` and `cells`, one after the other.
    numbers : (8,) float64 array
        Threshold in standard deviations, penalty per norm of a row, tolerance, rounding of a dual
        value, most steps, rows and columns of the grid, and the model's error per highest reading,
        in deviations of the noise.
    """

    rows: NDArray[Any]
    nodes: NDArray[Any]
    whitening: Floats
    offset: Floats
    root: Floats
    bump: NDArray[Any]
    stamps: NDArray[Any]
    places: NDArray[np.int32]
    numbers: Floats

    @property
    def norms(self) -> NDArray[Any]:
        """Of the rows, (K,)."""
        return np.asarray(self.nodes[NORM])

    @property
    def threshold(self) -> float:
        """Standard deviations that the most significant node must exceed."""
        return float(self.numbers[THRESHOLD])

    @property
    def tolerance(self) -> float:
        """Gap at which the search ends."""
        return float(self.numbers[TOLERANCE])

    @property
    def shared(self) -> NDArray[Any]:
        """B s of each row, (K,)."""
        return np.asarray(self.nodes[SHARED])

    @property
    def unshared(self) -> NDArray[Any]:
        """The rows B (K, W) of independent noise, in which few taxels see a node."""
        return np.asarray(self.rows + np.outer(self.shared, self.root))

    def without(self, valid: NDArray[np.bool_]) -> "DualProblem":
        """The same without the taxels that are not `valid` (L,), by some passes over one matrix."""
        offset = self.offset.copy()
        offset[: len(valid)] *= valid
        root, whitening = root_of(offset), self.whitening * valid
        heard = np.zeros(len(offset))
        heard[: len(valid)] = valid
        rows, nodes = np.empty_like(self.rows), self.nodes.copy()
        leave_out(self.rows, self.nodes[SHARED], self.root, heard, root, rows, nodes)
        return self._replace(rows=rows, nodes=nodes, whitening=whitening, root=root)


@njit(fastmath={"reassoc", "contract", "nsz"})
def leave_out(
    rows: NDArray[Any],
    shared: NDArray[Any],
    root: Floats,
    heard: Floats,
    less: Floats,
    out: NDArray[Any],
    nodes: NDArray[Any],
) -> None:
    """Write into `out` rows (K, W) where taxels are `heard` (W,), 1, and 0 where not.

    `shared` and `root` are those of the rows, `less` is s of what is heard. Into `nodes` go the
    norms of the new rows, and B s; see `whitened`.
    """
    width = len(root)
    part = np.empty(width)
    for node in range(len(rows)):
        row, new, level, along, square = rows[node], out[node], float(shared[node]), 0.0, 0.0
        for taxel in range(width):
            part[taxel] = (row[taxel] + level * root[taxel]) * heard[taxel]
            along += part[taxel] * less[taxel]
        for taxel in range(width):
            value = part[taxel] - along * less[taxel]
            new[taxel] = value
            square += value * value
        nodes[NORM, node], nodes[SHARED, node] = np.sqrt(square), along


class Memory(NamedTuple):
    """What lasts from reading to reading, and room to work in.

    Attributes
    ----------
    taxels : (6 + W, W) array
        Whitened readings, dual, prediction, slope of the dual value, step and scratch; then a
        Cholesky factor.
    nodes : (4, K) array
        Amounts before they are cut at 0 and their change by a step, of the nodes that are searched;
        products of all rows; amounts of the best answer.
    lists : (6, K or more) int array
        Nodes that are searched, active, in the factor, pressed in the best answer; all nodes; room
        for the clock, and counts.
    measures : (9,) float64 array
        Gap, objective, ns per work of a step, a pass and the way back; share that a step leaves
        unsolved; what the paces come to in the mean.
    """

    taxels: NDArray[Any]
    nodes: NDArray[Any]
    lists: Ints
    measures: Floats

    @classmethod
    def of(cls, nodes: int, width: int, kind: np.dtype[Any]) -> "Memory":
        """Room for a problem; pages that are never written are never taken."""
        lists = np.zeros((COUNTS + 1, max(nodes, COUNTED)), dtype=np.int64)
        lists[ALL] = np.arange(lists.shape[1])
        taxels = np.zeros((LOWER + width, width), kind)
        return cls(taxels, np.zeros((AMOUNT + 1, nodes), kind), lists, np.zeros(TYPICAL + 3))
