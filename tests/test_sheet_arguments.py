"""What a sheet cannot be made of, or read, is refused."""

import numpy as np
import pytest
from test_sheet import LAYER, PLACES, usual_pair

import skinfield as sf
from skinfield.errors import InputError


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"positions": np.zeros((0, 2))}, "at least one taxel"),
        ({"positions": np.zeros((5, 3))}, r"shape \(5, 3\)"),
        ({"positions": [[0.0, np.nan]]}, "positions"),
        ({"positions": PLACES * 1e3}, "metres"),
        ({"pitch": 0.0}, "pitch"),
        ({"pitch": 1e-300}, "pitch is 1e-300, expected a number from 1e-06 to 1"),
        ({"pitch": 1e300}, "pitch"),
        ({"pad_diameter": np.nan}, "pad_diameter"),
        ({"noise_std": -1.0}, r"noise_std\[0\]"),
        ({"noise_std": 1e-300}, r"noise_std\[0\]"),
        ({"noise_std": np.inf}, r"noise_std\[0\]"),
        ({"noise_std": np.ones(3)}, "one per taxel"),
        ({"solver": sf.PseudoInverse()}, "GaussianField"),
        ({"layer": 2e-3}, "Layer"),
        ({"quantity": sf.Gap}, "object"),
        ({"mechanics": "bonded"}, "BondedLayer"),
        ({"finder": sf.ContactFinder}, "object"),
        ({"cut": 0.5}, "cut"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"most_iterations": 0}, "most_iterations"),
        ({"precision": np.int32}, "precision"),
        ({"pitch": 0.2e-3}, "larger cells"),
        ({"solver": sf.GaussianField(length_scale=12e-3)}, "length_scale"),
        ({"quantity": sf.Gap(pad_averaged=False), "mechanics": sf.HalfSpace()}, "edges"),
    ],
    ids=lambda value: value if isinstance(value, str) else next(iter(value)),
)
def test_what_cannot_be_used_is_refused(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        sf.Sheet(**{"positions": PLACES, "layer": LAYER, **arguments})


def test_wrong_readings_are_refused() -> None:
    sheet = usual_pair()[0]
    with pytest.raises(InputError, match="one per taxel"):
        sheet(np.zeros(3))
    with pytest.raises(InputError, match=r"readings\[7\] is inf"):
        sheet(np.where(np.arange(len(sheet)) == 7, np.inf, 0.0))
    out = np.empty(len(sheet.grid), dtype=np.float32)
    with pytest.raises(InputError, match="float64"):
        sheet.apply(np.zeros(len(sheet)), out)
    with pytest.raises(InputError, match=r"one per cell of sheet\.grid"):
        sheet.apply(np.zeros(len(sheet), dtype=np.float32), out[1:])


@pytest.mark.parametrize("reading", [1e300, -1e300, 1e30])
def test_readings_beyond_single_precision_are_refused(reading: float) -> None:
    sheet, dense = usual_pair()
    before = sheet(dense.readings).pressure
    readings = dense.readings.copy()
    readings[7] = reading
    with pytest.raises(InputError, match=r"readings\[7\] is .*expected at most 1e\+12 times its"):
        sheet(readings)
    out = np.empty(len(sheet.grid), dtype=np.float32)
    single = dense.readings.astype(np.float32)
    for wrong in (np.inf, 3e38):
        single[7] = wrong
        with pytest.raises(InputError, match="deviations of their noise, expected finite ones"):
            sheet.apply(single, out)
    again = sheet(dense.readings).pressure
    assert np.abs(again - before).max() < 1e-2 * before.max(), "it goes on as before"


def test_the_highest_reading_that_is_taken_is_answered() -> None:
    sheet = usual_pair()[0]
    sheet.reset()
    unit = sheet(np.where(np.arange(len(sheet)) == 7, sheet.noise_std, 0.0)).pressure
    sheet.reset()
    most = sheet(np.where(np.arange(len(sheet)) == 7, 1e12 * sheet.noise_std, 0.0)).pressure
    assert np.abs(most - 1e12 * unit).max() < 1e-4 * most.max()
    sheet.reset()


def test_a_capacitance_that_no_pad_has_is_refused() -> None:
    sheet = sf.Sheet(PLACES[:5], LAYER, quantity=sf.Capacitance())
    for reading in (-1.0, -3.0):
        with pytest.raises(InputError, match=r"readings\[2\] is -.*expected above -1"):
            sheet([0.0, 0.0, reading, 0.0, 0.0])
    with pytest.raises(InputError, match="deviations of their noise"):
        sheet([0.0, 0.0, np.nextafter(-1.0, 0.0), 0.0, 0.0])


@pytest.mark.parametrize("deadline", [1e10, 1e300])
def test_a_deadline_beyond_reason_is_none(deadline: float) -> None:
    sheet, dense = usual_pair()
    sheet.reset()
    free = sheet(dense.readings)
    sheet.reset()
    late = sheet(dense.readings, deadline=deadline)
    assert late.deadline_met
    assert late.iterations == free.iterations


def test_taxels_too_dense_for_the_cut_are_told() -> None:
    """Cut late, the matrix is positive definite; cut early, it has eigenvalues below 0."""
    places = np.random.default_rng(0).uniform(-20e-3, 0, (60, 2)) * [1.0, 0.0]
    fine = sf.Sheet(places, LAYER, solver=sf.Tikhonov(snr=30.0), cut=1e-4)
    _ = fine(fine.noise_std).contacts
    coarse = sf.Sheet(places, LAYER, solver=sf.Tikhonov(snr=30.0), cut=2e-2)
    with pytest.raises(InputError, match="positions are so dense"):
        _ = coarse(np.random.default_rng(1).normal(size=60)).contacts


def test_contacts_of_taxels_in_one_place() -> None:
    sheet = sf.Sheet(np.full((150, 2), 3e-3), LAYER, solver=sf.Tikhonov())
    readings = sheet.noise_std * (50.0 + np.random.default_rng(0).normal(size=150))
    (contact,) = sheet(readings).contacts
    assert np.abs(contact.position[:2] - 3e-3).max() < 0.2e-3
