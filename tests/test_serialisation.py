"""A reconstructor that is written down and made anew is the same."""

import json
import pickle

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import FileError, InputError
from skinfield.reconstruct.serialisation import (
    ReconstructorConfig,
    plain_from_value,
    value_from_plain,
)
from skinfield.signal import Calibration, CySkinCount, ICubByte

PATCH = sf.layouts.hexagon72()
GRID = sf.Grid.square(PATCH, nodes=8)
SOLVERS = (
    sf.GaussianField(snr=12.5), sf.Tikhonov(), sf.PseudoInverse(resample=True), sf.Inverse(),
    sf.NonNegative(length_scale=4e-3), sf.ContactFit(most_contacts=3),
)  # fmt: skip


def again(config: ReconstructorConfig) -> ReconstructorConfig:
    plain = json.loads(json.dumps(config.to_plain(), allow_nan=False))
    return ReconstructorConfig.from_plain(plain)


@pytest.mark.parametrize("solver", SOLVERS, ids=lambda s: type(s).__name__)
def test_settings_come_back_equal(solver) -> None:
    config = ReconstructorConfig(
        PATCH, sf.Layer(1.7e-3, 1.23e5, 0.47), GRID, sf.HalfSpace(capped=True),
        sf.Capacitance(order=2), solver, np.linspace(0.001, 0.003, 72), sf.ContactFinder(edge=0.3),
    )  # fmt: skip
    for other in (again(config), pickle.loads(pickle.dumps(config))):
        for name in ("layer", "mechanics", "quantity", "solver", "finder"):
            assert getattr(other, name) == getattr(config, name)
        np.testing.assert_array_equal(other.noise_std, config.noise_std)
        np.testing.assert_array_equal(other.patch.positions, PATCH.positions)
        np.testing.assert_array_equal(other.grid.positions, GRID.positions)


@pytest.mark.parametrize(
    "patch",
    [PATCH, sf.layouts.cylinder(radius=25e-3, length=15e-3, arc_angle=1.0)],
    ids=["flat", "round"],
)
def test_the_reconstructor_is_the_same_to_the_last_bit(patch) -> None:
    grid = sf.Grid.square(patch, nodes=7)
    first = sf.Reconstructor(patch, grid=grid, solver=sf.Tikhonov())
    second = again(ReconstructorConfig.of(first)).reconstructor()
    np.testing.assert_array_equal(second.operator, first.operator)


@pytest.mark.parametrize(
    "base",
    [None, sf.SphericalBase((0, 0, 0), 0.1), sf.CylindricalBase((0, 0, 0.1), (1, 2, 3), 0.1)],
)
def test_curved_layers_come_back_equal(base) -> None:
    layer = sf.CurvedLayer(inextensible_cover=True, base=base)
    text = json.dumps(plain_from_value("it", layer))
    assert value_from_plain("it", json.loads(text)) == layer
    assert pickle.loads(pickle.dumps(layer)) == layer


def test_settings_with_intervals_are_refused_with_what_to_do() -> None:
    rec = sf.Reconstructor(PATCH, grid=GRID, solver=sf.Tikhonov())
    plain = ReconstructorConfig.of(rec).to_plain()
    older = ReconstructorConfig.from_plain(plain | {"intervals": None})  # of a file with none
    assert older.solver == rec.solver
    with pytest.raises(FileError, match=r"intervals that were learnt .* recording anew"):
        ReconstructorConfig.from_plain(plain | {"intervals": {"is": "Intervals"}})


@pytest.mark.parametrize(
    "value",
    [
        ICubByte(no_load=235), CySkinCount(), np.float32, float("inf"), -0.0, 1e-300, 2**60,
        None, True, "ü",
        (1, (2.5, "a")), np.array([[1.5, np.nan]]), np.arange(3, dtype=np.uint64),
        np.array([True, False]),
    ],
    ids=str,
)  # fmt: skip
def test_values_come_back(value) -> None:
    text = json.dumps(plain_from_value("it", value), allow_nan=False)
    found = value_from_plain("it", json.loads(text))
    assert type(found) is type(value)
    if isinstance(value, np.ndarray):
        assert found.dtype == value.dtype
        np.testing.assert_array_equal(found, value)
    else:
        assert repr(found) == repr(value)


def test_a_calibration_comes_back() -> None:
    made = Calibration.from_convention(PATCH, ICubByte(), gain=-171.0, noise_std=0.5)
    found = value_from_plain("it", json.loads(json.dumps(plain_from_value("it", made))))
    counts = np.random.default_rng(0).integers(0, 240, (5, 72)).astype(float)
    np.testing.assert_array_equal(
        found.relative_capacitance_from_counts(counts),
        made.relative_capacitance_from_counts(counts),
    )


class Own:
    def prepare(self, model):
        raise NotImplementedError


def test_what_is_not_skinfields_own_cannot_be_written() -> None:
    with pytest.raises(InputError, match=r"solver is a Own, which results cannot hold"):
        plain_from_value("solver", Own())
    with pytest.raises(InputError, match=r"mechanics.psi is a function"):
        plain_from_value("mechanics", sf.HalfSpace(psi=lambda nu: nu))


@pytest.mark.parametrize(
    ("plain", "said"),
    [
        ({"is": "Popen", "args": ["true"]}, "solver is a 'Popen', expected one of"),
        ({"is": "GaussianField", "snr": 10.0}, "other settings than this skinfield's"),
        ({"is": "GaussianField", "snr": -1.0, "length_scale": None}, "cannot be made: snr is"),
        ({"array": "|O", "shape": [1], "values": [None]}, "is no type of an array"),
        ({"array": "<f8", "shape": [7], "values": [1.0]}, "cannot be made"),
        ({"array": 3}, "cannot be made"),
        ({"float": "a"}, "cannot be made"),
        ({}, "is a 'None'"),
    ],
)
def test_what_was_never_written_is_refused(plain, said) -> None:
    with pytest.raises(FileError, match=said):
        value_from_plain("solver", plain)
