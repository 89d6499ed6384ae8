"""Load histories of viscoelastic solids against closed forms, an ODE solver and Ting's contact."""

from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from skinfield.elastic.viscoelastic import StandardLinearSolid, lagged
from skinfield.errors import InputError

SOLID = StandardLinearSolid(relaxed_fraction=0.7, time_constant=0.8)


def creep(solid, time):
    """E∞ J(t) after a step of stress."""
    return 1.0 - (1.0 - solid.relaxed_fraction) * np.exp(-time / solid.retardation_time)


def relaxation(solid, time):
    """E(t) / E∞ after a step of strain."""
    rest = solid.relaxed_fraction
    return (rest + (1.0 - rest) * np.exp(-time / solid.time_constant)) / rest


def irregular_history(seed, samples=40, duration=8.0):
    rng = np.random.default_rng(seed)
    time = np.sort(rng.uniform(0, duration, samples))
    return time, rng.uniform(-1.0, 2.0, samples)


def test_a_step_of_force_creeps_as_the_standard_solid_does():
    time = np.array([0.0, 0.0, 0.3, 1.0, 5.0, 60.0])
    force = np.array([0.0, 2.0, 2.0, 2.0, 2.0, 2.0])
    slow = 0.8 / 0.7  # retardation time, τ E₀ / E∞
    closed = 2.0 * (1.0 - 0.3 * np.exp(-time / slow))
    closed[0] = 0.0
    assert SOLID.effective_force(time, force) == pytest.approx(closed, rel=1e-13)
    assert SOLID.effective_force(time[1:], force[1:]) == pytest.approx(closed[1:], rel=1e-13)
    assert creep(SOLID, time[1:]) * 2.0 == pytest.approx(closed[1:], rel=1e-13)


def test_a_step_of_depth_relaxes_to_the_relaxed_modulus():
    time = np.array([0.0, 0.5, 2.0, 50.0])
    expected = (1.0 - 0.3 * (1.0 - np.exp(-time / 0.8))) / 0.7
    assert SOLID.relaxing_force(time, np.ones(4)) == pytest.approx(expected, rel=1e-13)
    assert relaxation(SOLID, time) == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("seed", range(3))
def test_it_agrees_with_an_ode_solver_on_an_irregular_history(seed):
    time, force = irregular_history(seed)
    part, tau = 1.0 - SOLID.relaxed_fraction, SOLID.time_constant

    def dashpots(t, x):
        strain = np.interp(t, time, force) + part * x[0]  # in units of σ / E₀
        return (strain - x) / tau

    strain = [force[0]]  # the first value is a step: dashpots have not moved
    state = np.zeros(1)
    for start, stop, value in zip(time[:-1], time[1:], force[1:], strict=True):
        done = solve_ivp(dashpots, (start, stop), state, rtol=1e-10, atol=1e-12)
        state = done.y[:, -1]
        strain.append(value + part * state[0])
    relaxed = np.array(strain) * SOLID.relaxed_fraction
    assert SOLID.effective_force(time, force) == pytest.approx(relaxed, abs=1e-8)


@pytest.mark.parametrize("frequency", [0.05, 0.3, 2.0])
def test_cycles_have_the_complex_modulus(frequency):
    period = 1.0 / frequency
    cycles = int(60 / period) + 3  # until what was at the start is forgotten
    time = np.linspace(0, cycles * period, cycles * 400 + 1)
    depth = np.sin(2 * np.pi * frequency * time)
    force = SOLID.relaxing_force(time, depth)
    last = slice(-401, -1)
    wave = np.exp(-2j * np.pi * frequency * time[last])
    ratio = (force[last] @ wave) / (depth[last] @ wave)
    tau, rest = SOLID.time_constant, SOLID.relaxed_fraction
    lost = (1.0 - rest) / (1 + 2j * np.pi * frequency * tau)
    assert ratio == pytest.approx((1 - lost) / rest, rel=2e-4)


@given(seed=st.integers(0, 999), extra=st.integers(1, 30))
def test_more_samples_of_the_same_history_change_nothing(seed, extra):
    time, force = irregular_history(seed, samples=6)
    more = np.sort(np.append(time, np.linspace(time[0], time[-1], extra)))
    there = np.searchsorted(more, time)
    many = SOLID.effective_force(more, np.interp(more, time, force))
    assert many[there] == pytest.approx(SOLID.effective_force(time, force), abs=1e-12)


@given(seed=st.integers(0, 999))
def test_the_effective_force_never_exceeds_the_largest_force_so_far(seed):
    time, force = irregular_history(seed)
    effective = SOLID.effective_force(time, np.abs(force))
    assert (effective <= np.maximum.accumulate(np.abs(force)) + 1e-12).all()
    assert (effective >= -1e-12).all()


def test_several_histories_at_once_are_each_by_itself():
    time = irregular_history(0)[0]
    forces = np.random.default_rng(5).normal(size=(len(time), 2, 3))
    together = SOLID.effective_force(time, forces)
    alone = SOLID.effective_force(time, forces[:, 1, 2])
    assert together[:, 1, 2] == pytest.approx(alone, abs=1e-14)


def test_an_elastic_solid_remembers_nothing():
    time, force = irregular_history(1)
    elastic = StandardLinearSolid(relaxed_fraction=1.0)
    assert (elastic.effective_force(time, force) == force).all()
    assert (elastic.relaxing_force(time, force) == force).all()


def integral(kernel, time, until, since, values):
    """∫ kernel(t - s) dv(s) from `since` to `until`, for each t; v is given at `time`."""
    middle, steps = 0.5 * (time[1:] + time[:-1]), np.diff(time)
    high = np.clip((until[:, None] - time[:-1]) / steps, 0.0, 1.0)
    low = np.clip((since[:, None] - time[:-1]) / steps, 0.0, 1.0)
    return (kernel(np.maximum(time[:, None] - middle, 0.0)) * (high - low)) @ np.diff(values)


def sphere_after_ting(solid, rise, samples=1201):
    """Sphere on a half-space whose contact radius a rises and falls, after Ting (1966).

    F(t) = ∫ E(t - s) d(a³) up to t₁(t), the moment at which the radius, while it grew, was what it
    is at t; depth = a² - ∫ J(t - s) dI(s) since the radius falls, I(s) = ∫ E(s - r) d(a²) from
    t₁(s) to s. Radius, depth and force in units of the largest radius and the elastic values there.
    """
    time = np.linspace(0.0, 2.0 * rise, samples)
    grows = time <= rise
    radius = np.sqrt(np.where(grows, time, 2.0 * rise - time) / rise)
    twin = np.where(grows, time, np.interp(radius, radius[grows], time[grows]))
    zero = np.zeros(samples)
    force = integral(partial(relaxation, solid), time, twin, zero, radius**3)
    inner = integral(partial(relaxation, solid), time, time, twin, radius**2)
    recovered = integral(partial(creep, solid), time, time, np.minimum(time, rise), inner)
    return time, radius, radius**2 - recovered, force, grows


@pytest.mark.parametrize(
    ("rise", "of_force", "of_depth"),
    [(0.1, 0.011, 0.036), (1.0, 0.051, 0.074), (10.0, 0.021, 0.023)],
)
def test_contact_is_exact_while_it_grows_and_off_by_a_stated_part_while_it_shrinks(
    rise, of_force, of_depth
):
    solid = StandardLinearSolid(relaxed_fraction=0.85, time_constant=1.0)
    time, radius, depth, force, grows = sphere_after_ting(solid, rise)
    effective = solid.effective_force(time, force)
    by_area = np.abs(effective - radius**3)
    by_depth = np.abs(np.maximum(effective, 0.0) ** (2 / 3) - depth)
    assert by_area[grows].max() < 1e-6
    assert by_depth[grows].max() < 1e-6
    assert 0.9 * of_force < by_area[~grows].max() < of_force
    assert 0.9 * of_depth < by_depth[~grows].max() < of_depth


def test_a_lag_follows_its_closed_form_from_any_start():
    time = np.linspace(0, 5, 11)
    assert lagged(time, np.full(11, 3.0), 2.0, start=1.0) == pytest.approx(
        3.0 - 2.0 * np.exp(-time / 2.0), rel=1e-13
    )
    assert (lagged(time, time, 0.0) == time).all()
    assert lagged(time, time, 1e-12)[1:] == pytest.approx(time[1:], abs=1e-11)
    assert lagged(time, time, 1e12)[-1] == pytest.approx(12.5e-12, rel=1e-9)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: StandardLinearSolid(0.0), "relaxed_fraction is 0.0, expected"),
        (lambda: StandardLinearSolid(0.5, -1.0), "time_constant is -1.0, expected"),
        (lambda: SOLID.effective_force([0, 1, 0.5], [1, 2, 3]), r"time\[2\] is 0.5 s after 1.0 s"),
        (lambda: SOLID.effective_force([0, 1], [1, np.nan]), r"values\[1\] is nan"),
        (lambda: SOLID.effective_force([0, 1], [1, 2, 3]), "values has shape"),
    ],
)
def test_errors_say_what_was_expected(make, words):
    with pytest.raises(InputError, match=words):
        make()
