"""Forces that only push: a small dense problem of what the surface yields to each of them."""

import numpy as np

from skinfield.errors import Floats, InputError


def push_to_depth(flexibility: Floats, heights: Floats, depth: float) -> Floats:
    """Forces (n,) >= 0 that keep every node below a body whose lowest point is at a depth.

    With C the flexibility they minimise f.C.f/2 - (depth - heights).f, which is a least-squares
    problem in the Cholesky factor of C, and which Lawson and Hanson's method ends exactly.

    Parameters
    ----------
    flexibility : (n, n) array
        Displacement into the layer per force.
    heights : (n,) array
        Of the body above its lowest point.
    depth : float
    """
    from scipy.linalg import cholesky, solve_triangular
    from scipy.optimize import nnls

    factor = cholesky((flexibility + flexibility.T) / 2, lower=True)
    wanted = solve_triangular(factor, depth - heights, lower=True)
    forces, _ = nnls(factor.T, wanted, maxiter=30 * len(heights))
    return np.asarray(forces)


def push_with_force(flexibility: Floats, heights: Floats, force: float) -> tuple[float, Floats]:
    """Depth of the body, and the forces (n,) whose sum is given.

    The sum grows with the depth, at a rate that the nodes in touch fix: Newton's method.
    """
    depth = float(heights.min()) + force * float(flexibility.diagonal().mean())
    for _ in range(60):
        forces = push_to_depth(flexibility, heights, depth)
        touching = forces > 0
        if touching.any():
            inverse = np.linalg.inv(flexibility[np.ix_(touching, touching)])
            step = (force - forces.sum()) / inverse.sum()
        else:
            step = depth - heights.min()
        depth += float(step)
        if abs(step) <= 1e-12 * max(abs(depth), 1e-12):
            return depth, forces
    raise InputError(f"force is {force!r} in units of E h², expected one that a contact can carry")
