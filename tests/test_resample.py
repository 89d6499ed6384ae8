"""Virtual taxels: convex combinations over the Delaunay triangles of the taxels."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from skinfield.elastic.resample import resampling_matrix
from skinfield.errors import InputError

seeds = st.integers(0, 2**32 - 1)


def scattered(seed: int, count: int = 40):
    rng = np.random.default_rng(seed)
    return rng.uniform(-20e-3, 20e-3, (count, 2)), rng.uniform(-30e-3, 30e-3, (300, 2))


def affine(places):
    return 3.0 + 200.0 * places[:, 0] - 70.0 * places[:, 1]


@settings(max_examples=30, deadline=None)
@given(seeds, st.integers(3, 80))
def test_weights_are_convex_and_reproduce_affine_readings(seed, count) -> None:
    taxels, nodes = scattered(seed, count)
    matrix, inside = resampling_matrix(taxels, nodes)
    weights = matrix.toarray()
    assert weights.shape == (300, count)
    assert (weights >= 0).all()
    assert ((weights > 0).sum(axis=1) <= 3).all()
    np.testing.assert_allclose(weights.sum(axis=1), inside, atol=1e-14)
    got = matrix @ affine(taxels)
    np.testing.assert_allclose(got[inside], affine(nodes)[inside], atol=1e-10)


@settings(max_examples=20, deadline=None)
@given(seeds)
def test_inside_is_the_convex_hull(seed) -> None:
    taxels, nodes = scattered(seed)
    matrix, inside = resampling_matrix(taxels, nodes)
    assert (inside == (Delaunay(taxels).find_simplex(nodes) >= 0)).all()
    np.testing.assert_allclose((matrix @ taxels)[inside], nodes[inside], atol=1e-12)


def test_nodes_on_taxels_and_edges_hear_only_those() -> None:
    taxels = np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]]) * 1e-3
    nodes = np.vstack([taxels, (taxels[0] + taxels[1]) / 2, 0.25 * taxels[1] + 0.75 * taxels[2]])
    matrix, inside = resampling_matrix(taxels, nodes)
    assert inside.all()
    want = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.5, 0], [0, 0.25, 0.75]])
    np.testing.assert_allclose(matrix.toarray(), want, atol=1e-15)
    assert matrix.nnz == 7


def test_taxels_at_one_place_share_its_weight() -> None:
    taxels = np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 4.0], [4.0, 0.0], [4.0, 1e-10]]) * 1e-3
    matrix, _ = resampling_matrix(taxels, np.array([[1e-3, 1e-3], [4e-3, 0.0]]))
    want = [[0.5, 1 / 12, 0.25, 1 / 12, 1 / 12], [0, 1 / 3, 0, 1 / 3, 1 / 3]]
    np.testing.assert_allclose(matrix.toarray(), want, atol=1e-9)


@pytest.mark.parametrize("jitter", [0.0, 1e-12, 1e-10, 1e-8, 1e-6])
def test_a_regular_array_with_dirty_borders_stays_exact(jitter: float) -> None:
    rng = np.random.default_rng(3)
    lattice = np.stack(np.meshgrid(np.arange(8.0), np.arange(6.0)), axis=-1).reshape(-1, 2) * 5e-3
    taxels = lattice + rng.normal(0.0, jitter, lattice.shape)
    nodes = np.vstack([lattice, rng.uniform([0, 0], [35e-3, 25e-3], (2000, 2))])
    matrix, inside = resampling_matrix(taxels, nodes)
    weights = matrix.toarray()
    assert (weights >= 0).all()
    np.testing.assert_allclose(weights.sum(axis=1), inside, atol=1e-14)
    off = np.abs(matrix @ affine(taxels) - affine(nodes))
    assert off[inside].max() < 2e-8  # the triangulation's own tolerance, 1e-9 of the extent


@pytest.mark.parametrize(
    ("taxels", "message"),
    [
        (np.empty((0, 2)), "taxels has 0 distinct places"),
        ([[0, 0], [1, 0], [1, 0], [0, 0]], "taxels has 2 distinct places"),
        ([[0, 0], [1, 1], [2, 2], [3, 3]], "taxels has 4 places, all on one line"),
        ([[0, 0], [1, 1], [np.nan, 2]], r"taxels\[\(2, 0\)\] is nan"),
        ([[0, 0, 0], [1, 1, 0], [1, 2, 0]], r"taxels has shape \(3, 3\)"),
    ],
)
def test_taxels_without_a_triangulation_are_an_error(taxels, message: str) -> None:
    with pytest.raises(InputError, match=message):
        resampling_matrix(np.asarray(taxels, float), np.zeros((1, 2)))
