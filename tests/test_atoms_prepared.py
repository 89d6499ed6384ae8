"""What a fit is prepared from: its sums against plain ones, and no more than it needs."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from test_atoms_search import fitter_of, noisy

from skinfield.elastic.round_gap import ANGLES, RADII, RoundGap
from skinfield.solve.atoms.fit_kernel import refine
from skinfield.solve.atoms.fitter import ContactFitter
from skinfield.solve.atoms.posterior import inverses
from skinfield.solve.atoms.table import Point, ring_sums

Floats = NDArray[np.float64]


@pytest.fixture(scope="module", name="fitter")
def _fitter() -> ContactFitter:
    return fitter_of("capacitance")


def test_touches_are_what_a_fit_says_without_what_takes_longest(fitter: ContactFitter) -> None:
    readings = noisy("capacitance", 4)
    found = fitter.touches(readings)
    assert "_moves" not in vars(fitter._renderer)  # displacements are not tabulated
    fitter.reset()
    fit = fitter.fit(readings)
    fitter.reset()
    assert len(found.contacts) == len(fit.contacts) == 1
    assert found.explained
    assert_array_equal(found.pressure, fit.pressure)
    assert_array_equal(found.contacts[0].covariance, fit.contacts[0].covariance)
    idle = fitter.touches(0.0 * readings)
    assert idle.explained
    assert not idle.contacts
    assert not idle.pressure.any()
    fitter.reset()


def test_all_that_is_refined_is_compiled_once(fitter: ContactFitter) -> None:
    for seed in (1, 2):
        fitter.touches(noisy("capacitance", seed))
        fitter.touches(noisy("capacitance", seed, (2e-3, -5e-3)) + noisy("capacitance", 3))
    fitter.reset()
    assert len(refine.signatures) == 1


def test_inverses_over_what_is_free() -> None:
    roots = np.random.default_rng(2).normal(size=(3, 6, 6))
    hessians = roots @ roots.transpose(0, 2, 1)
    hessians[2] *= -1.0  # no minimum
    free = np.array([True, True, True, True, False, False])
    found, half = inverses(hessians, free)
    part = np.linalg.inv(hessians[0, 2:4, 2:4])
    assert_allclose(found[0, 2:4, 2:4], part, rtol=1e-6)
    assert_allclose(half[0], -0.5 * np.log(np.linalg.det(part)), rtol=1e-6)
    assert np.count_nonzero(found[1]) == 4
    found, half = inverses(hessians, np.arange(6) < 3)  # one that is free beside the place
    assert_array_equal(half == np.inf, [False, False, True])
    assert np.isfinite(found).all()


def test_a_pad_reads_the_mean_over_its_points() -> None:
    distances, radius = np.array([0.0, 0.7, 3.0]), 1.1
    gap = RoundGap.of(2 * radius, distances, edges=[1.3])
    node, weight = np.polynomial.legendre.leggauss(RADII)
    rho, angle = radius * (node + 1) / 2, (np.arange(ANGLES) + 0.5) * np.pi / ANGLES
    for row, distance in zip(gap.averages, distances, strict=True):
        at = np.hypot(distance + rho[:, None] * np.cos(angle), rho[:, None] * np.sin(angle))
        for power in range(3):  # quadratics are met exactly by the elements
            share = weight * (node + 1) / 2
            mean = float((share[:, None] * at**power).sum() / share.sum() / ANGLES)
            assert row @ gap.nodes**power == pytest.approx(mean, rel=1e-12)


def test_rings_are_sums_of_points() -> None:
    mesh = np.concatenate([np.linspace(0.0, 1.0, 20, endpoint=False), np.linspace(1.0, 9.0, 60)])
    spline = CubicSpline(mesh, np.exp(-mesh))
    point = Point(mesh, np.ascontiguousarray(spline.c.T), 1.0 / 20, 8.0 / 59, 20)
    r, radii, forces = np.linspace(0.0, 8.0, 17), np.array([0.4, 3.0]), np.array([0.2, 0.8])
    counts = np.array([9, 30])
    expected = np.zeros(len(r))
    for ring, force, count in zip(radii, forces, counts, strict=True):
        cosine = np.cos((np.arange(count) + 0.5) * math.pi / count)
        square = r[:, None] ** 2 + ring**2 - 2.0 * ring * r[:, None] * cosine
        expected += force * spline(np.sqrt(square)).mean(axis=1)
    assert_allclose(ring_sums(r, radii, forces, counts, point), expected, rtol=1e-9)
