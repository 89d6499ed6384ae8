"""When two touches are told from one: against other optimisers and Monte Carlo."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.special import chdtri

from skinfield.design import Places, SkinDesign, Touch, few_places, two_point_distance
from skinfield.design.discrimination import needed_noncentrality
from skinfield.elastic import BaseStress, Capacitance, Layer
from skinfield.errors import Floats, InputError
from skinfield.skin.generators import hexagon72
from skinfield.solve.atoms.atom_readings import PARAMETERS, predict
from skinfield.solve.atoms.fit_kernel import HIGHEST_LOG, LOWEST_LOG
from skinfield.solve.atoms.table import Tables, atom_tables

THICKNESS = 4e-3
LAYER = Layer(THICKNESS, 150e3, 0.5)
RADIUS = 1e-3
BALLS = np.zeros(2, np.int64)
LOW, HIGH = [-99.0, -99.0, -9.0, LOWEST_LOG], [99.0, 99.0, 9.0, HIGHEST_LOG]


SKIN = SkinDesign(patch=hexagon72(), layer=LAYER, quantity=BaseStress(), noise_std=400.0)
QUIET = replace(SKIN, noise_std=200.0)


def places_near(*points: tuple[float, float]) -> Places:
    """The whole patch as ground for a second touch, judged at the places nearest to some mm."""
    whole = Places.over(hexagon72(), 2e-3)
    rows = [np.linalg.norm(whole.plane * 1e3 - p, axis=1).argmin() for p in points]
    picked = Places(whole.grid, whole.nodes[rows])
    picked.__dict__["inside"] = whole.inside
    return picked


class Fits:
    """Least squares of one contact, or of two equal ones, by SciPy."""

    def __init__(self, skin: SkinDesign) -> None:
        self.tables: Tables = atom_tables(skin.physics)
        self.taxels = skin.patch.plane / THICKNESS
        self.white = 1 / skin.noise

    def read(self, atoms: Floats) -> tuple[Floats, Floats]:
        """Whitened readings (L,) of N contacts of 4 parameters, and derivatives (L, N, 4)."""
        full = np.pad(np.atleast_2d(atoms), ((0, 0), (0, PARAMETERS - 4)))
        out, slopes = (
            np.empty(len(self.taxels)),
            np.empty((len(full), PARAMETERS, len(self.taxels))),
        )
        predict(full, BALLS[: len(full)], self.taxels, self.tables, out, slopes)
        return out * self.white, np.moveaxis(slopes[:, :4] * self.white, -1, 0)

    def misfit(self, pair: Floats) -> float:
        """Squared misfit of the one contact that explains the readings of a pair best."""
        middle, readings = pair.mean(axis=0) + np.array([0, 0, np.log(2), 0]), self.read(pair)[0]
        wider = [middle + np.array([0, 0, 0, step]) for step in (0.3, 0.8, 1.3)]
        found = [
            least_squares(
                lambda v: self.read(v)[0] - readings, np.clip(start, LOW, HIGH),
                jac=lambda v: self.read(v)[1][:, 0], bounds=(LOW, HIGH), x_scale="jac",
            )
            for start in (*wider, *pair)
        ]  # fmt: skip
        return 2 * min(float(fit.cost) for fit in found)


def pair_at(place: Floats, distance: float, angle: float, force: float) -> Floats:
    one = np.array([*place / THICKNESS, np.log(force), np.log(RADIUS / THICKNESS)])
    other = one.copy()
    other[:2] += distance / THICKNESS * np.array([np.cos(angle), np.sin(angle)])
    return np.stack([one, other])


def test_at_the_distance_the_best_single_touch_misses_by_what_is_needed() -> None:
    needed, fits = needed_noncentrality(0.05), Fits(SKIN)
    found = two_point_distance(SKIN, Touch(1.0, RADIUS), places_near((8, 8), (3, 9)), ways=4)
    for place, distances in zip(found.places.plane, found.distance, strict=True):
        for angle, distance in zip(found.ways, distances, strict=True):
            if not np.isfinite(distance):
                continue
            at, closer = (
                fits.misfit(pair_at(place, d, angle, 1.0)) for d in (distance, 0.8 * distance)
            )
            assert 0.7 * needed < at < 1.4 * needed
            assert closer < needed


def test_more_force_and_less_noise_bring_two_closer() -> None:
    places = places_near((8, 8), (3, 9), (-9, 2))
    base, firm, quiet, daring = (
        two_point_distance(skin, Touch(force, RADIUS), places, ways=6, error_rate=rate)
        for skin, force, rate in (
            (SKIN, 0.5, 0.05), (SKIN, 1.0, 0.05), (QUIET, 0.5, 0.05), (SKIN, 0.5, 0.2)
        )
    )  # fmt: skip
    for better in (firm, quiet, daring):
        assert (better.typical < base.typical).all()
        assert (better.worst <= base.worst).all()
    # readings are proportional: twice the force is half the noise
    np.testing.assert_allclose(firm.distance, quiet.distance, rtol=0.06)
    assert (base.worst >= base.typical).all()


def test_needed_noncentrality_is_where_both_errors_meet() -> None:
    rng = np.random.default_rng(0)
    for rate in (0.05, 0.01):
        needed = needed_noncentrality(rate)
        pairs = rng.standard_normal((400_000, 2)) + np.array([np.sqrt(needed), 0.0])
        missed = float(((pairs**2).sum(axis=1) < chdtri(2, rate)).mean())
        assert missed == pytest.approx(rate, rel=0.06)


def test_two_touches_are_judged_in_proportion_also_where_readings_bend() -> None:
    places, touch = places_near((8, 8)), Touch(0.2, RADIUS)
    bent = SkinDesign(patch=hexagon72(), layer=LAYER, quantity=Capacitance())
    straight = replace(bent, quantity=Capacitance(order=1))
    found = [two_point_distance(d, touch, places, ways=3).distance for d in (bent, straight)]
    np.testing.assert_array_equal(found[0], found[1])


def test_few_places_are_few_and_bad_input_is_named() -> None:
    assert 60 < len(few_places(SKIN, 100)) <= 100
    for wrong in ({"ways": 0}, {"error_rate": 0.7}):
        with pytest.raises(InputError, match=next(iter(wrong))):
            two_point_distance(SKIN, Touch(1.0, RADIUS), **wrong)
