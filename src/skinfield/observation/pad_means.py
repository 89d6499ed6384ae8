"""Means over pads of what is known at the nodes of a mesh, compiled."""

from numba import njit

from skinfield.errors import Floats, Ints


@njit(cache=True, nogil=True, error_model="numpy")
def add_means(nodes: Floats, at: Floats, share: Floats, pad: Ints, out: Floats) -> None:
    """Add to means over pads (N, M) what points add, which are in order."""
    start = 0
    for n in range(len(at)):
        while start + 3 < len(nodes) - 1 and at[n] >= nodes[start + 2]:
            start += 2
        x = (at[n] - nodes[start]) / (nodes[start + 2] - nodes[start])
        row = out[pad[n]]
        row[start] += share[n] * (1 - x) * (1 - 2 * x)  # an element's functions
        row[start + 1] += share[n] * 4 * x * (1 - x)
        row[start + 2] += share[n] * x * (2 * x - 1)
