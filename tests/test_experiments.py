"""The paper's experiments: their parts against closed forms, other methods and known numbers."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtr, ndtri

import skinfield as sf
from skinfield.errors import InputError
from skinfield.lab.experiments import EXPERIMENTS, chosen
from skinfield.lab.paper import BALL, FIELD, LAYER, PAPER, PLACES, paper_patch, readings, sites
from skinfield.lab.report import SMOKE as SETTINGS
from skinfield.lab.score import wilson
from skinfield.lab.sections.detection import Trial, field_peak, noisy, roc, threshold
from skinfield.lab.sections.imposed import ADJACENT, DEPTH, SEPARATE, discs_of, half_width, truth_of
from skinfield.lab.sections.resolutions import roughness
from skinfield.lab.sections.timing import exponents
from skinfield.simulate import press


def test_wilson_interval_of_the_textbook() -> None:
    low, high = wilson(10, 20)
    assert (low, high) == pytest.approx((0.2993, 0.7007), abs=1e-4)  # Newcombe (1998)
    assert wilson(0, 20)[0] == 0.0
    assert wilson(20, 20) == pytest.approx((0.8389, 1.0), abs=1e-4)


def test_threshold_and_roc_of_normal_distributions() -> None:
    rng, alarms = np.random.default_rng(2), np.array([0.01, 0.1, 0.5])
    quiet, pressed = rng.normal(size=100_000), rng.normal(size=50_000) + 1.5
    assert threshold(quiet, 1e-2) == pytest.approx(2.326, abs=0.03)  # the normal quantile
    assert roc(quiet, pressed, alarms) == pytest.approx(ndtr(1.5 + ndtri(alarms)), abs=0.01)


def test_statistic_of_the_field_is_the_highest_pressure_of_an_estimate() -> None:
    for method in (PAPER, FIELD):
        reconstruct = method.prepared(12, 1e3)
        values = np.random.default_rng(4).normal(scale=1e3, size=(5, 72))
        estimate = reconstruct(values)
        inside = reconstruct.plan.noise.std > 0
        highest = estimate.pressure[:, inside].max(axis=1)
        assert field_peak(reconstruct)(values) == pytest.approx(highest)
        scaled = (estimate.pressure / np.where(inside, reconstruct.plan.noise.std, np.inf)).max(1)
        assert field_peak(reconstruct, in_deviations=True)(values) == pytest.approx(scaled)


def test_readings_of_a_moved_press_are_those_of_a_press_in_place() -> None:
    place = np.array([[3e-3, -4e-3]])
    patch = paper_patch()
    moved = readings(BALL, 0.5, 0.3e-3, place, "stress")
    body = replace(BALL.body, force=0.5, position=(3e-3, -4e-3))
    in_place = press(LAYER, [body], 24e-3, 0.3e-3)
    direct = in_place.base_stress(patch.plane, patch.pad_diameter)
    assert np.abs(moved[0] - direct).max() < 0.01 * direct.max()


@pytest.mark.parametrize(
    ("place", "neighbours", "distance"),
    [(PLACES[0], 1, 0.0), (PLACES[1], 2, 2.75e-3), (PLACES[2], 3, 3.175e-3)],
)
def test_sites_are_where_they_say(place: str, neighbours: int, distance: float) -> None:
    found = sites()[place]
    assert len(found) > 10
    apart = np.sort(np.linalg.norm(found[:, None] - paper_patch().plane[None], axis=2), axis=1)
    assert apart[:, :neighbours] == pytest.approx(distance, abs=0.02e-3)
    assert (apart[:, neighbours] > distance + 1e-3).all()


def test_noise_is_independent_of_the_trial_before_and_shrinks_when_averaged() -> None:
    trial = Trial(PLACES[0], 0.2)
    clean = trial.clean(SETTINGS, 100, 9)
    once, many = (noisy(trial, SETTINGS, (9,), (9, n), n) for n in (1, 100))
    assert np.std(once - clean) == pytest.approx(3.8e3, rel=0.03)
    assert np.std(many - clean) == pytest.approx(380.0, rel=0.03)
    assert np.array_equal(once, noisy(trial, SETTINGS, (9,), (9, 1), 1))


def test_half_width_of_a_gaussian() -> None:
    grid = sf.Grid.square(paper_patch(), nodes=60)
    bump = np.exp(-np.sum((grid.plane - [1e-3, 2e-3]) ** 2, axis=1) / (2 * (3e-3) ** 2))
    width = half_width(grid, bump, np.array([1e-3, 2e-3]), 12e-3)
    assert width == pytest.approx(2.3548 * 3e-3, rel=0.02)


def test_roughness_of_a_plane_and_of_a_spike() -> None:
    grid = sf.Grid.square(paper_patch(), nodes=15)
    near = np.linalg.norm(grid.plane, axis=1) < 12e-3
    assert roughness(grid, 1.0 + 20 * grid.plane[:, 0], near) == pytest.approx(0.0, abs=1e-12)
    spike = np.zeros(len(grid))
    spike[len(grid) // 2] = 1.0
    bends = near.sum() * 2
    assert roughness(grid, spike, near) == pytest.approx(np.sqrt(12 / bends), rel=1e-9)


def test_discs_are_neighbours_or_far_apart() -> None:
    for case, low, high in ((ADJACENT, 5.4e-3, 5.6e-3), (SEPARATE, 20e-3, 35e-3)):
        places = discs_of(paper_patch())[case]
        sides = np.linalg.norm(places - np.roll(places, 1, axis=0), axis=1)
        assert ((low < sides) & (sides < high)).all()


def test_imposed_depth_is_there_and_in_equilibrium_with_the_base() -> None:
    truth = truth_of(SEPARATE)
    away = np.linalg.norm(truth.grid.plane[:, None] - truth.places[None], axis=2).min(axis=1)
    under = away < 1.5e-3
    assert truth.indentation[under] == pytest.approx(DEPTH, rel=1e-3)
    assert (truth.pressure >= 0).all()
    grid = sf.Grid.square(paper_patch(), nodes=40)
    pressure, indentation = truth.on(grid)
    assert pressure.sum() * grid.cell_area == pytest.approx(truth.force, rel=1e-9)
    assert indentation.max() <= DEPTH * (1 + 1e-6)


def test_exponents_tell_a_power_law_from_an_exponential() -> None:
    grids = (10, 20, 30, 40)
    nodes = np.array(grids) ** 2
    power, about_power, about_exponential = exponents(grids, 1e-9 * nodes**2.5)
    assert power == pytest.approx(2.5)
    assert about_power < 1e-9 < about_exponential
    _, about_power, about_exponential = exponents(grids, 1e-9 * np.exp(nodes / 400))
    assert about_exponential < 1e-9 < about_power


def test_parts_are_chosen_by_name_or_figure() -> None:
    assert chosen([]) == EXPERIMENTS
    assert [each.name for each in chosen(["fig3", " FIG6 "])] == ["imposed", "detection"]
    with pytest.raises(InputError, match="'fig10' names no experiment, expected some of imposed"):
        chosen(["fig10"])
