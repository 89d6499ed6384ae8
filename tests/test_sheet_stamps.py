"""Stamps of a sheet: the kernel at any offset, and nothing beyond the lattice."""

from typing import Any

import numpy as np
import pytest
from test_sheet import LAYER, PAD, PLACES, fine_pair, usual_pair

import skinfield as sf
from skinfield.errors import InputError


def test_stamps_are_the_kernel_at_any_offset() -> None:
    stamp = fine_pair()[0].plan.stamps.read
    rng = np.random.default_rng(0)
    offset = rng.uniform(size=(40, 2))
    cell = np.arange(1 - stamp.reach, stamp.reach + 1)
    x, y = (
        cell[None, None, :] - offset[:, 0, None, None],
        cell[None, :, None] - offset[:, 1, None, None],
    )
    places = np.stack(np.broadcast_arrays(x, y), axis=-1) * 1.5e-3
    kernel = sf.BondedLayer().base_stress(LAYER, places.reshape(-1, 2), 1.5e-3, PAD)
    error = np.abs(stamp.at(offset).ravel() - kernel).max() / kernel.max()
    assert error < 1e-4  # the cut


def test_what_is_cut_off_is_below_the_cut() -> None:
    stamp = usual_pair()[0].plan.stamps.read
    far = stamp.reach + np.linspace(0.0, 10.0, 200)
    on_axis = np.column_stack([far, 0 * far]) * 1.5e-3
    peak = sf.BondedLayer().base_stress(LAYER, np.zeros((1, 2)), 1.5e-3, PAD)[0]
    beyond = np.abs(sf.BondedLayer().base_stress(LAYER, on_axis, 1.5e-3, PAD)).max() / peak
    assert beyond < 1e-3


def test_stamps_and_prediction_are_transposes() -> None:
    sheet = sf.Sheet(PLACES, LAYER, solver=sf.Tikhonov(), precision=np.float64)
    from skinfield.solve.sheet.kernels import add_stamps
    from skinfield.solve.sheet.plan import parts_of

    rng = np.random.default_rng(2)
    field, value = rng.normal(size=len(sheet.grid)), rng.normal(size=len(sheet))
    out, plan = np.empty(field.size), sheet.plan
    parts = parts_of(plan.stamps.spread, np.float64)
    add_stamps(value[plan.placing.order], plan.corner, plan.offset, parts, sheet.shape[1], out)
    assert np.vdot(out, field) == pytest.approx(value @ sheet.predict(field), rel=1e-12)


def assert_on_the_lattice(sheet: sf.Sheet) -> None:
    rows, columns = sheet.shape
    for stamp in (sheet.plan.stamps.read, sheet.plan.stamps.spread):
        column, row = (sheet.plan.placing.cell - (stamp.reach - 1)).T
        corner = sheet.plan.placing.corner(stamp.reach, columns)
        assert (corner == row * columns + column).all()
        assert min(column.min(), row.min()) >= 0
        assert (column + stamp.width).max() <= columns
        assert (row + 2 * stamp.reach).max() <= rows


@pytest.mark.parametrize("length", [0.5e-3, 1.5e-3, 4e-3])
def test_all_stamps_lie_on_the_lattice(length: float) -> None:
    solver = sf.GaussianField(length_scale=length)
    rng = np.random.default_rng(0)
    for index in range(60):
        places = PLACES[: 1 + index % 7] + rng.uniform(-1.0, 1.0, 2)
        if index % 2:
            places = np.round(places / 1.5e-3) * 1.5e-3  # where rounding decides on the cell
        sheet = sf.Sheet(places, LAYER, pitch=1.5e-3, solver=solver, cut=5e-3)
        assert_on_the_lattice(sheet)


@pytest.mark.parametrize("along", [(1.0, 0.0), (0.0, 1.0), (0.6, -0.8)])
@pytest.mark.parametrize("pitch", [1.1e-3, 1.5e-3, 2.7e-3])
def test_also_of_taxels_in_a_row(along: tuple[float, float], pitch: float) -> None:
    solver = sf.GaussianField(length_scale=1.5e-3)
    for far in (0.0, -3 * pitch, 1.0, -1e3, 1e9):
        places = np.outer(np.arange(-9, 10) * 3 * pitch, along) + far
        sheet = sf.Sheet(places, LAYER, pitch=pitch, solver=solver, cut=5e-3)
        assert_on_the_lattice(sheet)


def test_where_a_sheet_lies_does_not_matter() -> None:
    readings = usual_pair()[1].readings
    expected = usual_pair()[0](readings).pressure
    for shift in ((300, -700), (-67_000, 67_000)):  # cells: half a metre, a hundred
        moved = sf.Sheet(PLACES + np.array(shift) * 1.5e-3, LAYER)
        assert np.abs(moved(readings).pressure - expected).max() < 1e-4 * expected.max()


def test_a_place_that_numbers_cannot_tell_is_refused() -> None:
    for far in (1e14, -1e20, 1e200):
        with pytest.raises(InputError, match="expected metres from an origin on or near the sheet"):
            sf.Sheet(PLACES + far, LAYER)


@pytest.mark.parametrize("fewer", [(2, 0), (0, 2), (0, 0)])
def test_no_stamp_is_written_beside_the_lattice(
    fewer: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Compiled code checks nothing, so it must not be reached."""
    from skinfield.solve.sheet import plan

    around = plan.lattice_of

    def tight(*arguments: Any) -> sf.Grid:
        good = around(*arguments)
        moved = 0.0 if any(fewer) else 0.6  # cells
        shape = good.shape[0] - fewer[0], good.shape[1] - fewer[1]
        return sf.Grid(good.patch, shape, good.pitch, good.origin + moved * good.pitch)

    monkeypatch.setattr(plan, "lattice_of", tight)
    with pytest.raises(InputError, match="rounding moves them by cells"):
        sf.Sheet(PLACES, LAYER)
