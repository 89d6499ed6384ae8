"""Several rigid, frictionless bodies on the bonded layer at once, at small strain."""

from collections.abc import Sequence

from skinfield.errors import InputError, check_range
from skinfield.fem.contact_search import Body, ContactSearch, rough_zones
from skinfield.fem.small_strain import check_load
from skinfield.fem.solution_3d import BoxSolution
from skinfield.mechanics import Layer

COARSE = 0.35  # thicknesses; elements of the first mesh, which finds the contacts


def press_3d(
    layer: Layer, bodies: Sequence[Body], *, cell: float = 0.15, mirror: bool = False
) -> BoxSolution:
    """Press bodies into the layer, linear elastic and without friction.

    Bricks with Q2 displacement and Q1 pressure, MINRES preconditioned with scalar operators that
    are inverted exactly, and an active set of the nodes that touch.

    Parameters
    ----------
    layer : Layer
        Bonded at its base and held far away.
    bodies : sequence
        Each with `height`, `position`, and a `force` or a `depth`; they must not overlap.
    cell : float
        Side of the bricks below the contacts, in thicknesses.
    mirror : bool
        Whether everything is symmetric about y = 0: only one half is solved.

    Returns
    -------
    BoxSolution

    Raises
    ------
    InputError
        If there is no body, a body has not exactly one load, `mirror` is not true of them, or
        scikit-fem is missing.
    """
    if not bodies:
        raise InputError("bodies is empty, expected one or more to press with")
    check_range("cell", cell, 0.02, 1.0, "side of the bricks below a contact, in thicknesses")
    for body in bodies:
        check_load(layer, body.force, body.depth)
    first = ContactSearch.on(layer, bodies, rough_zones(layer, bodies), max(cell, COARSE), mirror)
    rough = first.settle(first.guess())
    fine = ContactSearch.on(layer, bodies, first.zones(rough), cell, mirror)
    return fine.solution(fine.settle(fine.like(first, rough)))
