"""The search for atoms: its minima, evidence and posterior against other ways to get them."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from contact_truth import LAYER, PATCH, truth
from numpy.testing import assert_array_equal
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

import skinfield as sf
from skinfield.elastic import BaseStress, BondedLayer, Capacitance, ObservationModel, Quantity
from skinfield.solve.atoms.fit_kernel import refined
from skinfield.solve.atoms.fitter import CURVATURE_STD, ContactFitter
from skinfield.solve.atoms.posterior import belief_of, laplace
from skinfield.solve.atoms.search import LOG_FORCES, AtomSet, FitProblem, search
from skinfield.solve.atoms.table import BALL, curvature_force

Floats = NDArray[np.float64]
H = LAYER.thickness
NOISE = {"stress": 400.0, "capacitance": 0.002}
BALL_6 = sf.simulate.Sphere(radius=6e-3, force=1.0)
PLACE = (-3.8e-3, 6.1e-3)


def fitter_of(name: str, **settings: Any) -> ContactFitter:
    quantity: Quantity = BaseStress() if name == "stress" else Capacitance()
    grid = sf.Grid.square(PATCH, nodes=12)
    model = ObservationModel.of(PATCH, LAYER, grid, BondedLayer(), quantity, NOISE[name])
    return ContactFitter(sf.ContactFit(extended=None, **settings), model)


@pytest.fixture(scope="module", name="fitters")
def _fitters() -> dict[str, ContactFitter]:
    return {name: fitter_of(name) for name in NOISE}


def noisy(name: str, seed: int, place: tuple[float, float] = PLACE, body: Any = BALL_6) -> Floats:
    rng = np.random.default_rng(seed)
    return truth(body, place, name) + rng.normal(scale=NOISE[name], size=len(PATCH))


@cache
def log_curvature_force() -> CubicSpline:
    """Of the exact contact, by the logarithm of its radius in thicknesses."""
    logs = np.linspace(-4.0, 4.0, 161)
    return CubicSpline(logs, [np.log(curvature_force(LAYER, float(np.exp(x) * H))) for x in logs])


def ball_residuals(problem: FitProblem, atom: Floats) -> Floats:
    """Of the readings and of the priors of a ball, made of the exact contact, and of an offset."""
    one = AtomSet(np.append(atom, [0.0, 0.0])[None], np.array([BALL]), 0.0, np.empty(0), np.eye(6))
    predicted = problem.alone(one, np.ones(1, dtype=np.bool_))
    prior = (float(log_curvature_force()(atom[3])) - atom[2] - np.log(6e-3)) / CURVATURE_STD
    off = (problem.inputs.readings - predicted) * problem.inputs.white
    if not problem.common:
        return np.append(off, prior)
    shared = np.append(problem.inputs.white, 1.0 / problem.common)  # what an offset of 1 would add
    off = np.append(off, 0.0)
    return np.append(off - shared * (shared @ off) / (shared @ shared), prior)


@pytest.mark.parametrize("name", list(NOISE))
@pytest.mark.parametrize("seed", [1, 2])
def test_refinement_ends_where_scipy_does(
    fitters: dict[str, ContactFitter], name: str, seed: int
) -> None:
    from scipy.optimize import least_squares

    problem = fitters[name].problem(noisy(name, seed))
    start = np.array([PLACE[0] / H + 0.3, PLACE[1] / H - 0.2, -0.2, 0.3])
    found = problem.refined(np.append(start, [0.0, 0.0])[None], np.array([BALL]))
    by_scipy = least_squares(
        lambda atom: ball_residuals(problem, atom),
        start,
        xtol=1e-12,
        ftol=1e-12,
        x_scale=[0.1, 0.1, 0.1, 0.1],
        diff_step=1e-5,
    )
    assert found.cost == pytest.approx(by_scipy.cost, abs=0.01)  # of half a chi-squared
    curvature = np.linalg.pinv(by_scipy.jac.T @ by_scipy.jac)
    off = found.atoms[0, :4] - by_scipy.x
    assert off @ np.linalg.solve(curvature, off) < 0.1  # deviations, squared
    inner = laplace(problem, found, 0).inner[0][:4, :4]
    assert np.sqrt(np.diag(inner)) == pytest.approx(np.sqrt(np.diag(curvature)), rel=0.1)


def drawn(problem: FitProblem, found: AtomSet, count: int) -> tuple[Floats, Floats]:
    """Samples (C, 4) of a ball about a minimum, wider than it, and their log-weights."""
    rng = np.random.default_rng(5)
    middle, inner = found.atoms[0, :4], laplace(problem, found, 0).inner[0][:4, :4]
    scale = np.linalg.cholesky(1.5 * inner)
    freedom = 5.0  # Student's t: heavier tails than what is sampled
    normal = rng.normal(size=(count, 4))
    chi = rng.chisquare(freedom, size=count) / freedom
    samples = middle + (normal / np.sqrt(chi)[:, None]) @ scale.T
    from scipy.stats import multivariate_t

    proposal = multivariate_t(middle, 1.5 * inner, freedom).logpdf(samples)
    cost = np.array([0.5 * np.square(ball_residuals(problem, atom)).sum() for atom in samples])
    return samples, -cost - proposal


@pytest.mark.parametrize("place", [PLACE, (-9e-3, 3e-3)], ids=["between", "beside"])
def test_evidence_and_covariance_are_those_of_samples(
    fitters: dict[str, ContactFitter], place: tuple[float, float]
) -> None:
    """Importance sampling of all four parameters against Laplace and against the walk."""
    problem = fitters["capacitance"].problem(noisy("capacitance", 3, place))
    start = np.array([[place[0] / H, place[1] / H, 0.0, 0.2, 0.0, 0.0]])
    found = problem.refined(start, np.array([BALL]))
    samples, log_weight = drawn(problem, found, 1500)
    highest = log_weight.max()
    weight = np.exp(log_weight - highest)
    assert weight.sum() ** 2 / np.square(weight).sum() > 100  # effective samples
    area = float(np.prod(problem.inputs.places[1] - problem.inputs.places[0]))
    prior = -np.log(area * LOG_FORCES) - 0.5 * np.log(2 * np.pi) - np.log(CURVATURE_STD)
    evidence = highest + np.log(weight.mean()) + prior
    assert problem.evidence(found) == pytest.approx(evidence, abs=0.5)
    weight /= weight.sum()
    mean = weight @ samples
    spread = np.sqrt(weight @ np.square(samples - mean))
    belief = belief_of(problem, found, 0, 100, 0, 0.9)
    assert np.sqrt(np.diag(belief.covariance)[:3]) == pytest.approx(spread[:3], rel=0.35)
    assert np.abs(belief.mean(BALL)[:3] - mean[:3]).max() < 0.5 * spread[:3].max()


def test_more_is_never_worse_and_nothing_is_left_out(fitters: dict[str, ContactFitter]) -> None:
    """Two balls 19 mm apart: each atom lowers the cost, the search keeps both."""
    readings = noisy("stress", 4, (-9e-3, 3e-3)) + truth(BALL_6, (1e-2, 2e-3), "stress")
    problem = fitters["stress"].problem(readings)
    found = search(problem, None, 8, 8)
    assert len(found) == 2
    one = search(problem, None, 1, 8)
    assert len(one) == 1
    assert found.cost + problem.threshold < one.cost < problem.nothing().cost
    assert problem.evidence(found) > problem.evidence(one) > problem.evidence(problem.nothing())
    warm = search(problem, found, 8, 8)
    assert warm.cost == pytest.approx(found.cost, abs=0.05)


@pytest.mark.parametrize("name", list(NOISE))
def test_noise_alone_is_seldom_taken_for_a_contact(
    fitters: dict[str, ContactFitter], name: str
) -> None:
    """4000 idle readings at 1e-3: 4 are expected at most, 12 would be one chance in a thousand."""
    rng = np.random.default_rng(6)
    seen = 0
    for _ in range(4000):
        readings = rng.normal(scale=NOISE[name], size=len(PATCH))
        seen += len(search(fitters[name].problem(readings), None, 8, 8)) > 0
    assert seen <= 11


def test_the_stated_rate_sets_the_threshold(fitters: dict[str, ContactFitter]) -> None:
    """At a rate a hundred times higher, weaker touches are found; idle ones more often, too."""
    bold, careful = fitter_of("stress", false_alarm_rate=0.1), fitters["stress"]
    assert bold.problem(np.zeros(72)).threshold < careful.problem(np.zeros(72)).threshold
    rng = np.random.default_rng(7)
    idle = rng.normal(scale=NOISE["stress"], size=(600, len(PATCH)))
    seen = sum(len(search(bold.problem(readings), None, 8, 8)) > 0 for readings in idle)
    assert 1 <= seen <= 85  # 60 and three deviations


def test_contacts_are_the_same_without_the_other_fields(fitters: dict[str, ContactFitter]) -> None:
    fitter, readings = fitters["capacitance"], noisy("capacitance", 4)
    found = fitter.fit(readings, fields=False)
    assert "_moves" not in vars(fitter._renderer)  # displacements are not tabulated
    fitter.reset()
    fit = fitter.fit(readings)
    fitter.reset()
    assert len(found.contacts) == len(fit.contacts) == 1
    assert found.explained
    assert_array_equal(found.pressure, fit.pressure)
    assert_array_equal(found.contacts[0].covariance, fit.contacts[0].covariance)
    idle = fitter.fit(0.0 * readings, fields=False)
    assert idle.explained
    assert not idle.contacts
    assert not idle.pressure.any()
    fitter.reset()


def test_all_that_is_refined_is_compiled_once(fitters: dict[str, ContactFitter]) -> None:
    fitter = fitters["capacitance"]
    for seed in (1, 2):
        fitter.fit(noisy("capacitance", seed), fields=False)
        both = noisy("capacitance", seed, (2e-3, -5e-3)) + noisy("capacitance", 3)
        fitter.fit(both, fields=False)
    fitter.reset()
    assert len(refined.signatures) == 1
