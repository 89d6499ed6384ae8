"""Choice between few contacts and a field, by evidence."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

import skinfield as sf
from skinfield import simulate
from skinfield.solve import Auto
from skinfield.solve.atoms.fit_kernel import STEPS
from skinfield.solve.auto import CONTACTS, FIELD, FIELD_NOTE, LINEAR_NOTE, Contest
from skinfield.solve.field_evidence import (
    AMPLITUDES,
    LENGTHS,
    MISFITS,
    SQUARES,
    FieldCovariance,
    field_evidence,
    misfit_gain,
    noise_density,
)
from skinfield.solve.linear import smoothed, taxel_distance

NOISE = 0.002
FOAM = sf.Layer(thickness=2e-3, young_modulus=150e3, poisson_ratio=0.3)


@pytest.fixture(scope="module")
def rec():
    return sf.Reconstructor(sf.layouts.hexagon72(), FOAM, solver=Auto(), noise_std=NOISE)


@pytest.fixture(scope="module")
def operator(rec):
    return rec.solver.prepare(rec.model)


@pytest.fixture
def data(operator):
    return operator.data()


def noise(seed, count=1):
    return np.random.default_rng(seed).normal(0.0, NOISE, (count, 72)).squeeze()


def broad_load(model, seed, peak=0.15):
    """Readings of a pressure that varies over some taxels, everywhere on the patch."""
    wave = 2 * np.pi * model.grid.plane / 30e-3 + np.random.default_rng(seed).uniform(0, 6, 2)
    readings = model.matrix @ (1.0 + 0.5 * np.sin(wave).prod(axis=1))
    return readings * peak / readings.max()


@pytest.mark.parametrize("silent", [[], [4], [0, 1, 7, 8], [0, 1, 5, 6, 7, 11], [*range(11)]])
def test_evidence_of_a_field_is_the_mean_density_of_its_priors(silent):
    patch = sf.layouts.rectangular(rows=4, columns=3)
    model = sf.Reconstructor(patch, noise_std=np.linspace(1e-3, 3e-3, 12)).model
    readings = np.random.default_rng(1).normal(0.0, 0.01, 12)
    offset = np.full((12, 12), (5.0 * model.noise_std.mean()) ** 2)
    valid, densities = np.delete(np.arange(12), silent), []
    for length in LENGTHS:
        far = length * taxel_distance(model.taxels, model.grid.pitch)
        gram = smoothed(model.grid, model.matrix, far) @ model.matrix.T
        gram *= 12 / (np.diagonal(gram) / model.noise_std**2).sum()
        for amplitude in AMPLITUDES:
            for misfit in MISFITS:
                own = np.diag((misfit * model.noise_std) ** 2)
                cov = (amplitude**2 * gram + own + offset)[np.ix_(valid, valid)]
                densities.append(multivariate_normal(cov=cov).logpdf(readings[valid]))
    expected = np.logaddexp.reduce(densities) - np.log(len(densities))
    covariance, readings[silent] = FieldCovariance.of(model, 5.0), 0.0
    priors = covariance.priors(np.isin(np.arange(12), valid))
    value = field_evidence(priors, SQUARES, readings, *covariance.room)
    assert value == pytest.approx(expected, rel=1e-9)


def test_density_of_noise_has_all_its_constants(operator):
    readings, white, common = noise(2), np.full(72, 1.0 / NOISE), 5.0 * NOISE
    shared = common**2 / (1.0 + common**2 * (white @ white))
    expected = multivariate_normal(cov=np.eye(72) * NOISE**2 + common**2)
    assert noise_density(white, shared, common) == pytest.approx(expected.logpdf(np.zeros(72)))
    plain = [multivariate_normal(cov=np.eye(72) * s**2).logpdf(readings / NOISE) for s in MISFITS]
    squares = float(np.square(readings / NOISE).sum())
    gain = np.logaddexp.reduce(plain) - np.log(len(plain)) - plain[0]
    assert misfit_gain(squares, 72) == pytest.approx(gain)


def test_an_idle_patch_is_no_field_however_noisy(operator, data):
    for reading in (*noise(3, 60), *2.0 * noise(4, 30), *4.0 * noise(5, 30)):
        data.reset()
        assert operator.solve(reading, data).fit is not None


def test_a_ball_is_a_contact_and_a_broad_load_a_field(rec):
    rec.reset()
    ball = simulate.press(FOAM, [simulate.Sphere(radius=6e-3, position=(-9e-3, 3e-3))], 66e-3)
    one = rec(ball.capacitance(rec.patch.plane, rec.patch.pad_diameter) + noise(4))
    assert len(one.contacts) == 1
    assert one.normal_force == pytest.approx(1.0, rel=0.15)
    assert one.notes == ()
    rec.reset()
    load = broad_load(rec.model, 5)
    assert FIELD_NOTE in rec(load + noise(5)).notes


def test_while_a_field_rests_no_contacts_are_sought(operator, data):
    load, marks = broad_load(operator.model, 6), data.contacts.fit.memory.marks
    assert operator.solve(load + noise(6), data).fit is None
    assert marks[STEPS] > 0
    marks[STEPS] = 0
    for reading in load + noise(7, 20):
        assert operator.solve(reading, data).notes == (FIELD_NOTE,)
    assert marks[STEPS] == 0
    assert operator.solve(noise(8), data).fit is not None


def test_readings_that_no_pressure_makes_are_answered_by_a_linear_field(operator, data):
    data.contest.winner = FIELD
    found = operator.solve(0.3 * np.resize([1.0, -1.0], 72), data)
    assert LINEAR_NOTE in found.notes
    assert found.solver == "GaussianField"
    assert found.pressure.min() < 0.0
    data.reset()
    found = operator.solve(broad_load(operator.model, 9), data)
    assert found.notes == (FIELD_NOTE,)
    assert found.solver == "NonNegative"
    assert found.pressure.min() >= 0.0


def test_taxels_that_are_left_out_do_not_matter(operator):
    valid = np.arange(72) % 9 > 0
    part, load = operator.without(valid), broad_load(operator.model, 5, peak=0.25) + noise(5)
    found = part.solve(load, part.data()).keep()
    wrong = np.where(valid, load, 1e3)
    assert found.solver == "NonNegative"
    assert np.array_equal(part.solve(wrong, part.data()).pressure, found.pressure)


def test_the_winner_stays_at_the_border():
    contest = Contest()
    leads = [0.0, 6.0, 8.0, 1.0, -6.0, -8.0, 0.0]
    found = [contest.decide(0.0, lead, count=1, margin=7.0) for lead in leads]
    assert found == [CONTACTS, CONTACTS, FIELD, FIELD, FIELD, CONTACTS, CONTACTS]
    assert Contest(FIELD).decide(0.0, -1.0, count=0, margin=7.0) == CONTACTS


def test_what_passes_the_idle_test_holds_neither_a_contact_nor_a_field(operator, data):
    known = operator.contact_fit, operator.wide
    passed = [0, 0, 0]
    loads = [0.0, 0.01, 1.0]  # of none, a faint broad one and a palm
    for kind, peak in enumerate(loads):
        load = broad_load(operator.model, 12, peak=peak) if peak else np.zeros(72)
        for reading in load + noise(12 + kind, 20):
            data.reset()
            solution = operator.solve(reading, data, touched=True)
            nothing = solution.fit is not None and not data.count
            data.reset()
            idle = known[0].rests(reading, data.contacts, known[1])
            passed[kind] += idle
            assert nothing or not idle
    assert passed[0] >= 19
    assert passed[2] == 0


def test_an_interrupted_search_is_not_compared_with_a_field_at_once():
    contest = Contest()
    contest.go_on(True)
    assert not contest.is_ripe
    contest.go_on(False)
    assert contest.is_ripe
    for _ in range(50):
        contest.go_on(True)
    assert contest.is_ripe
