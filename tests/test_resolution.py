"""Resolution of a layout: limits against closed forms and simulation, and its judgement."""

from dataclasses import replace
from math import erfc

import numpy as np
import pytest

from skinfield.design import (
    Places,
    SkinDesign,
    Touch,
    blind_spots,
    detectable_force,
    judge,
    place_accuracy,
)
from skinfield.design.design import respond, snr_per_newton
from skinfield.design.discrimination import bounds
from skinfield.elastic import BaseStress, Capacitance, Gap, Layer, Quantity
from skinfield.elastic.axisymmetric import Paraboloid, indent_by_force
from skinfield.errors import Floats, InputError
from skinfield.simulate import Sphere, press
from skinfield.simulate.pressing.press import readings_anywhere
from skinfield.skin import Grid, Patch
from skinfield.skin.generators import hexagon72, icub_triangle, rectangular
from skinfield.solve.atoms.table import BALL, unit_pressure

LAYER = Layer(2e-3, 150e3, 0.5)
PLACES = np.array([[0, 7.48], [0, 0], [3, 9], [8, 1], [15, 5]]) * 1e-3
QUANTITIES = [(BaseStress(), 400.0), (Gap(), 0.002), (Capacitance(order=1), 0.002)]


SKIN = SkinDesign(patch=hexagon72(), layer=LAYER, quantity=Capacitance(order=1), noise_std=0.002)
STRESS = replace(SKIN, quantity=BaseStress(), noise_std=400.0)


def readings_by_cells(design: SkinDesign, touch: Touch, place: Floats) -> Floats:
    """Readings of a ball's pressure as a sum over small cells."""
    cell = touch.radius / 8
    reach = touch.radius + cell
    grid = Grid.window(design.patch, place - reach, place + reach, cell)
    away = np.linalg.norm(grid.plane - place, axis=1)
    pressure = unit_pressure(design.layer, design.mechanics, BALL, touch.radius, away)
    pressure *= touch.force / (pressure.sum() * grid.cell_area)
    matrix = design.quantity.matrix(
        design.mechanics, design.layer, grid, design.patch.plane, design.patch.pad_diameter
    )
    return np.asarray(matrix @ pressure)


@pytest.mark.parametrize(("quantity", "noise"), QUANTITIES)
def test_signal_to_noise_is_that_of_a_sum_over_cells(quantity: Quantity, noise: float) -> None:
    design, touch = replace(SKIN, quantity=quantity, noise_std=noise), Touch(0.5, 1.5e-3)
    found = respond(design, touch, PLACES[[0, 2, 3]]).snr
    expected = [
        np.linalg.norm(readings_by_cells(design, touch, place)) / noise
        for place in PLACES[[0, 2, 3]]
    ]
    np.testing.assert_allclose(found, expected, rtol=0.02)


@pytest.mark.parametrize(("name", "quantity", "noise"), [("stress", BaseStress(), 1e3),
                                                         ("gap", Gap(), 2e-3)])  # fmt: skip
def test_accuracy_is_the_bound_of_a_simulated_press(
    name: str, quantity: Quantity, noise: float
) -> None:
    layer, force, radius = replace(LAYER, thickness=4e-3), 0.5, 6e-3
    design = replace(SKIN, quantity=quantity, noise_std=noise, layer=layer)
    lighter, base, heavier = (
        readings_anywhere(
            press(layer, [Sphere(radius=radius, force=force * part)], 50e-3, 0.4e-3), 4e-3, name
        )
        for part in (0.95, 1.0, 1.05)
    )
    ways = 0.1e-3 * np.eye(2)
    expected = []
    for place in PLACES:
        seen = design.patch.plane - place
        slopes = [(base(seen - way) - base(seen + way)) / 0.2e-3 for way in ways]
        by_force = (heavier(seen) - lighter(seen)) / np.log(1.05 / 0.95)
        jacobian = np.column_stack([*slopes, by_force]) / noise
        expected.append(np.diag(np.linalg.inv(jacobian.T @ jacobian)))
    contact = [
        indent_by_force(layer, Paraboloid(radius=radius), force * part).contact_radius
        for part in (0.95, 1.0, 1.05)
    ]
    widening = np.log(contact[2] / contact[0]) / np.log(1.05 / 0.95)  # a heavier ball is wider
    gram = respond(design, Touch(force, contact[1]), PLACES).gram
    change = np.zeros((3, 5))
    change[[0, 1, 2], [1, 2, 3]], change[2, 4] = 1.0, widening
    place, log_force = bounds(np.einsum("ij,pjk,lk->pil", change, gram, change))
    np.testing.assert_allclose(place**2, [each[:2].sum() for each in expected], rtol=0.1)
    np.testing.assert_allclose(log_force**2, [each[2] for each in expected], rtol=0.1)


def test_forces_scale_with_the_noise_and_stress_knows_no_modulus() -> None:
    places = Places.over(hexagon72(), 3e-3)
    touch = Touch(0.2, 1e-3)
    quiet, loud = (replace(SKIN, noise_std=noise) for noise in (0.001, 0.003))
    one, three = (detectable_force(design, touch, places) for design in (quiet, loud))
    np.testing.assert_allclose(three.unknown_place, 3 * one.unknown_place, rtol=1e-9)
    hard = replace(STRESS, layer=replace(LAYER, young_modulus=2e6))
    maps = [
        (
            blind_spots(design, touch, places).snr,
            place_accuracy(design, touch, places).place_std,
            detectable_force(design, touch, places).unknown_place,
        )
        for design in (STRESS, hard)
    ]
    for one, other in zip(*maps, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-6)
    # a capacitive one reads the strain: half as stiff is half the noise
    stiff = replace(SKIN, layer=replace(LAYER, young_modulus=2 * LAYER.young_modulus))
    np.testing.assert_allclose(
        snr_per_newton(SKIN, 1e-3, PLACES), 2 * snr_per_newton(stiff, 1e-3, PLACES), rtol=1e-6
    )


@pytest.mark.parametrize("design", [SKIN, STRESS])
def test_more_taxels_are_never_worse(design: SkinDesign) -> None:
    fewer = replace(
        design, patch=design.patch.subset(np.arange(0, 72, 2)), noise_std=design.noise[::2]
    )
    touch = Touch(0.5, 1e-3)
    all_of, half = (respond(d, touch, PLACES) for d in (design, fewer))
    assert (all_of.snr >= half.snr * (1 - 1e-12)).all()
    for many, few in zip(
        bounds(all_of.gram[:, 1:4, 1:4]), bounds(half.gram[:, 1:4, 1:4]), strict=True
    ):
        assert (many <= few * (1 + 1e-9)).all()


def templates(design: SkinDesign, touch: Touch, points: Floats) -> Floats:
    """Whitened readings at points (P, 2) as unit vectors (P, L), by sums over cells."""
    rows = np.stack([readings_by_cells(design, touch, place) for place in points])
    rows = rows / design.noise
    return np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True))


@pytest.fixture(scope="module")
def bank() -> tuple[SkinDesign, Touch, Places, Floats]:
    layer, touch = replace(LAYER, thickness=4e-3), Touch(0.3, 2e-3)
    design = replace(SKIN, patch=icub_triangle(), layer=layer)
    places = Places.over(design.patch, 1e-3)
    return design, touch, places, templates(design, touch, places.plane)


def test_false_alarms_are_as_rare_as_stated(
    bank: tuple[SkinDesign, Touch, Places, Floats],
) -> None:
    design, touch, places, rows = bank
    searched = detectable_force(design, touch, places, false_alarm_rate=0.01).searched
    rng = np.random.default_rng(0)
    loudest = [(rng.standard_normal((1000, rows.shape[1])) @ rows.T).max(1) for _ in range(20)]
    largest = np.concatenate(loudest)
    for rate in (0.05, 0.01, 0.003):
        found = float((largest > searched.level(rate)).mean())
        spread = 3 * np.sqrt(rate / len(largest))
        assert 0.6 * rate - spread < found < 1.1 * rate + spread
    tail = 0.5 * erfc(searched.level(0.01) / np.sqrt(2))
    assert searched.independent(0.01) == pytest.approx(0.01 / tail, rel=1e-6)


def test_the_smallest_force_is_found_as_often_as_stated(
    bank: tuple[SkinDesign, Touch, Places, Floats],
) -> None:
    design, touch, places, rows = bank
    found = detectable_force(design, touch, places, false_alarm_rate=0.01, detection_rate=0.9)
    level = found.searched.level(0.01)
    rng = np.random.default_rng(1)
    for place in rng.integers(len(places), size=4):
        noise = rng.standard_normal((4000, rows.shape[1]))
        shape = readings_by_cells(design, replace(touch, force=1.0), places.plane[place])
        shape = shape / design.noise
        searched = ((noise + found.unknown_place[place] * shape) @ rows.T).max(axis=1) > level
        assert 0.885 < float(searched.mean()) < 0.965  # at least as often: a bound from below


def test_holes_of_a_thin_stress_skin_are_the_six_and_the_middle() -> None:
    found = blind_spots(STRESS, Touch(0.5, 1e-3), threshold=0.03)
    middle, *others = found.holes[:7]  # the rest are slits between two of them
    np.testing.assert_allclose(middle.middle, hexagon72().plane.mean(axis=0), atol=0.4e-3)
    away = [float(np.linalg.norm(hole.middle - middle.middle)) for hole in others]
    assert np.ptp(away) < 1e-3
    assert np.mean(away) == pytest.approx(16.7e-3, rel=0.02)
    share = sum(hole.area for hole in found.holes) / found.places.area
    assert share == pytest.approx(found.blind_share, rel=1e-9)
    assert 0 < middle.deepest < 0.03
    thicker = replace(STRESS, layer=replace(LAYER, thickness=4e-3))
    thick = blind_spots(thicker, Touch(0.5, 1e-3), threshold=0.03)
    assert thick.blind_share < found.blind_share / 3


def test_deep_touches_are_heard_better_and_never_through_the_base() -> None:
    design, places = replace(SKIN, quantity=Capacitance()), Places.over(hexagon72(), 3e-3)
    touch = Touch(0.3, 1e-3)
    bent, straight = (detectable_force(d, touch, places) for d in (design, design.linear))
    light = straight.unknown_place < 0.5
    assert (bent.unknown_place <= straight.unknown_place * 1.001)[light].all()
    on_taxel = int(straight.unknown_place.argmin())
    ratio = bent.unknown_place[on_taxel] / straight.unknown_place[on_taxel]
    assert 0.75 < ratio < 0.97  # the gap narrows: about 1 less its strain
    with pytest.raises(InputError, match="press the elastomer flat"):
        place_accuracy(design, Touch(5.0, 1e-3), places)


def test_thousand_taxels_take_memory_in_proportion() -> None:
    import tracemalloc

    design = replace(STRESS, patch=rectangular(rows=34, columns=34))
    places = Places.over(design.patch, 3e-3)
    snr_per_newton(design, 1e-3, places.plane[:2])
    tracemalloc.start()
    blind_spots(design, Touch(0.5, 1e-3), places)
    assert tracemalloc.get_traced_memory()[1] < 60e6  # all pairs of places and taxels: 400 MB
    tracemalloc.stop()


def test_judging_says_what_it_found() -> None:
    design = replace(STRESS, patch=icub_triangle())
    told: list[str] = []
    found = judge(design, Touch(0.5, 1e-3), Places.over(design.patch, 1e-3), on_map=told.append,
                  two_point_places=Places.over(design.patch, 5e-3), ways=4)  # fmt: skip
    assert len(told) == 4
    rows = {row.name: row for row in found.rows()}
    assert all(row.median <= row.p90 <= row.p95 <= row.worst for row in found.rows()[1:])
    place = rows["place deviation"]
    assert place.median == pytest.approx(np.median(found.accuracy.place_std) * 1e3, rel=0.05)
    assert "0.5 N" in found.verdict()
    assert "blind" in found.verdict()


def test_a_skin_that_feels_nothing_is_said_to() -> None:
    design = replace(STRESS, patch=icub_triangle(), noise_std=1e7)
    coarse = Places.over(design.patch, 2e-3)
    found = judge(design, Touch(0.5, 1e-3), coarse, two_point_places=coarse, ways=4)
    assert "is found nowhere; half of the patch places it no better than a guess" in found.verdict()
    assert "tells no two apart" in found.verdict()


def test_bad_input_is_named() -> None:
    touch, finer = Touch(0.5, 1e-3), r"pitch is 1e-06 m, which makes .* take 9.[0-9]e-05 m or"
    for words, call in (
        ("noise_std", lambda: replace(SKIN, noise_std=-1.0)),
        ("noise_std has shape", lambda: replace(SKIN, noise_std=np.ones(3))),
        ("radius is", lambda: blind_spots(STRESS, Touch(0.5, 0.1e-3))),
        ("force is", lambda: Touch(-1.0, 1e-3)),
        ("pitch is", lambda: Places.over(hexagon72(), -1.0)),
        (finer, lambda: Places.over(hexagon72(), 1e-6)),
        ("false_alarm_rate", lambda: detectable_force(STRESS, touch, false_alarm_rate=0.5)),
        ("threshold", lambda: blind_spots(STRESS, touch, threshold=2.0)),
    ):
        with pytest.raises(InputError, match=words):
            call()


def test_places_cover_the_patch_and_its_pads() -> None:
    patch = Patch(np.zeros((1, 2)))
    alone = Places.over(patch)
    assert alone.area == pytest.approx(np.pi * 2e-3**2, rel=0.05)
    places = Places.over(hexagon72(), 1e-3)
    values = np.arange(len(places), dtype=np.float64)
    picture = places.picture(values)
    np.testing.assert_array_equal(picture[places.inside], values)
    assert np.isnan(picture[~places.inside]).all()
