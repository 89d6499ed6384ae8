"""Virtual taxels at the nodes of a grid, by Delaunay triangulation: section III-B of the paper."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, check_finite, check_shape

if TYPE_CHECKING:
    from scipy.sparse import csr_array

FLAT = 1e-9  # of the taxels' extent: below it, places coincide and points lie on one line


def resampling_matrix(taxels: Floats, nodes: Floats) -> tuple["csr_array", NDArray[np.bool_]]:
    r"""Weights of the taxels around each node, built once for all readings.

    Parameters
    ----------
    taxels : (L, 2) array, m
        Places of the taxels in the plane, three or more that do not lie on one line. Taxels at the
        same place count as one, whose reading is the mean of theirs.
    nodes : (N, 2) array, m
        Places of the virtual taxels in the same plane.

    Returns
    -------
    matrix : (N, L) sparse CSR array
        Convex combinations: no weight is negative, rows sum to 1, or are empty outside.
    inside : (N,) bool array
        Which nodes lie in the convex hull of the taxels, border included. Elsewhere the paper's
        construction has no answer.

    Raises
    ------
    InputError
        If the taxels have no triangulation.

    Notes
    -----
    A node in the triangle of taxels a, b, c reads :math:`\alpha\hat\sigma_a + \beta\hat\sigma_b +
    \gamma\hat\sigma_c` with :math:`r_n = \alpha t_a + \beta t_b + \gamma t_c` and :math:`\alpha +
    \beta + \gamma = 1`: affine readings are reproduced exactly within the hull.
    """
    from scipy.spatial import Delaunay

    for name, places in (("taxels", taxels), ("nodes", nodes)):
        check_shape(name, places, (None, 2), "one (x, y) in metres per row, in the patch's plane")
        check_finite(name, places, "an absent one is left out, not marked by NaN")
    distinct, owner, origin, extent = _distinct(taxels)
    triangulation = Delaunay(distinct)
    scaled = (nodes - origin) / extent
    triangle = triangulation.find_simplex(scaled, tol=FLAT)
    inside = np.asarray(triangle >= 0)
    corners = triangulation.simplices[triangle]
    weights = np.zeros((len(nodes), 3))
    weights[inside] = _barycentric(triangulation.transform[triangle[inside]], scaled[inside])
    return _over_taxels(corners, weights, owner), inside


def _distinct(taxels: Floats) -> tuple[Floats, NDArray[np.int64], Floats, float]:
    """Distinct places scaled to extent 1, the place of each taxel, and the scaling."""
    origin = taxels.mean(axis=0) if len(taxels) else np.zeros(2)
    extent = float(np.abs(taxels - origin).max(initial=0.0)) or 1.0
    scaled = (taxels - origin) / extent
    _, first, owner = np.unique(
        scaled.round(9) + 0.0, axis=0, return_index=True, return_inverse=True
    )
    distinct, owner = scaled[first], np.asarray(owner, dtype=np.int64).ravel()
    spread = np.linalg.svd(distinct - distinct.mean(axis=0))[1] if len(distinct) >= 3 else [0.0]
    if spread[-1] <= FLAT:
        kind = "distinct places" if len(distinct) < 3 else "places, all on one line"
        raise InputError(
            f"taxels has {len(distinct)} {kind}, expected three or more that span an area: "
            "a triangulation needs triangles; solve on the taxels themselves instead"
        )
    return distinct, owner, origin, extent


def _barycentric(affine: Floats, places: Floats) -> Floats:
    """Weights of a triangle's three corners, (N, 3); `affine` (N, 3, 2) as Delaunay.transform."""
    first = np.einsum("nij,nj->ni", affine[:, :2], places - affine[:, 2])
    weights = np.column_stack([first, 1.0 - first.sum(axis=1)])
    weights[weights < FLAT] = 0.0  # a node on an edge or on a taxel hears no other
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def _over_taxels(
    corners: NDArray[np.int32], weights: Floats, owner: NDArray[np.int64]
) -> "csr_array":
    """Weights of distinct places (N, 3) as a matrix over taxels, each sharing with its doubles."""
    from scipy.sparse import csr_array

    count = np.bincount(owner)
    rows = np.repeat(np.arange(len(corners)), 3)
    shape = (len(corners), len(count))
    over_places = csr_array((weights.ravel(), (rows, corners.ravel())), shape=shape)
    over_places.eliminate_zeros()
    places_from_taxels = csr_array((1.0 / count[owner], (owner, np.arange(len(owner)))))
    return csr_array(over_places @ places_from_taxels)
