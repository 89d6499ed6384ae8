"""The search for atoms: its minima, evidence and posterior against other ways to get them."""

from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from contact_truth import LAYER, PATCH, truth
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

import skinfield as sf
from skinfield.elastic import BaseStress, BondedLayer, Capacitance, ObservationModel, Quantity
from skinfield.solve.atoms.alternatives_kernel import LOG_FORCES
from skinfield.solve.atoms.atom_readings import PARAMETERS, predict
from skinfield.solve.atoms.fit_kernel import NOW, SHARED, WHITE
from skinfield.solve.atoms.fitter import (
    CURVATURE_STD,
    FLAT_RADIUS,
    FLAT_STD,
)
from skinfield.solve.atoms.reading_kernel import answer_reading
from skinfield.solve.atoms.table import BALL, FLAT, curvature_force
from skinfield.solve.contact_fit import ContactOperator

Floats = NDArray[np.float64]
H = LAYER.thickness
NOISE = {"stress": 400.0, "capacitance": 0.002}
BALL_6 = sf.simulate.Sphere(radius=6e-3, force=1.0)
PLACE = (-3.8e-3, 6.1e-3)


class Prepared:
    """Operator with a memory."""

    def __init__(self, operator: ContactOperator) -> None:
        self.operator, self.fitter, self.data = operator, operator.fitter, operator.data()
        self.memory = self.data.fit.memory

    def fit(self, readings: Floats) -> SimpleNamespace:
        """Atoms at the minimum, from there to the posterior's mean, and their covariance."""
        solution, fit = self.operator.solve(readings, self.data).keep(), self.data.fit
        atoms, count = self.memory.atoms[NOW], fit.count
        return SimpleNamespace(
            atoms=atoms[:count].copy(),
            offsets=fit.posterior.offsets[:count].copy(),
            covariance=fit.posterior.covariance[:count].copy(),
            family=self.memory.family[NOW, :count].copy(),
            evidence=solution.evidence,
            solution=solution,
        )


def fitter_of(name: str, **settings: Any) -> Prepared:
    quantity: Quantity = BaseStress() if name == "stress" else Capacitance()
    grid = sf.Grid.square(PATCH, nodes=12)
    model = ObservationModel.of(PATCH, LAYER, grid, BondedLayer(), quantity, NOISE[name])
    return Prepared(sf.ContactFit(**settings).prepare(model))


@pytest.fixture(scope="module", name="fitters")
def _fitters() -> dict[str, Prepared]:
    return {name: fitter_of(name) for name in NOISE}


def noisy(name: str, seed: int, place: tuple[float, float] = PLACE, body: Any = BALL_6) -> Floats:
    rng = np.random.default_rng(seed)
    return truth(body, place, name) + rng.normal(scale=NOISE[name], size=len(PATCH))


@cache
def log_curvature_force() -> CubicSpline:
    """Of the exact contact, by the logarithm of its radius in thicknesses."""
    logs = np.linspace(-4.0, 4.0, 161)
    return CubicSpline(logs, [np.log(curvature_force(LAYER, float(np.exp(x) * H))) for x in logs])


def alone(fitter: Prepared, atom: Floats, family: int) -> Floats:
    """What one ball or flat end (4,) is read as, (L,)."""
    model = fitter.fitter.fit_model
    out, jacobian = np.empty(len(PATCH)), np.empty((1, PARAMETERS, len(PATCH)))
    one = np.append(atom, np.zeros(PARAMETERS - 4))[None]
    predict(one, np.array([family]), model.taxels, model.tables, out, jacobian)
    return out


def residuals(fitter: Prepared, readings: Floats, atom: Floats, family: int) -> Floats:
    """Of the readings and of the priors, made of the exact contact, and of an offset."""
    white = fitter.memory.taxels[WHITE]
    prior = (float(log_curvature_force()(atom[3])) - atom[2] - np.log(6e-3)) / CURVATURE_STD
    if family == FLAT:
        prior = (atom[3] - np.log(FLAT_RADIUS / H)) / FLAT_STD
    off = np.append((readings - alone(fitter, atom, family)) * white, 0.0)
    common = (
        fitter.operator.solver.common_mode
        * NOISE["stress" if readings.max() > 10 else "capacitance"]
    )
    shared = np.append(white, 1.0 / common)  # what an offset of 1 would add
    return np.append(off - shared * (shared @ off) / (shared @ shared), prior)


def cold(fitter: Prepared, readings: Floats) -> Any:
    fitter.data.reset()
    return fitter.fit(readings)


@pytest.mark.parametrize("name", list(NOISE))
@pytest.mark.parametrize("seed", [1, 4])
def test_refinement_ends_where_scipy_does(
    fitters: dict[str, Prepared], name: str, seed: int
) -> None:
    from scipy.optimize import least_squares

    fitter, readings = fitters[name], noisy(name, seed)
    fit = cold(fitter, readings)
    memory = fitter.memory
    (family,) = fit.family.tolist()
    by_scipy = least_squares(
        lambda atom: residuals(fitter, readings, atom, family),
        np.array([PLACE[0] / H + 0.3, PLACE[1] / H - 0.2, -0.2, 0.3]),
        xtol=1e-12,
        ftol=1e-12,
        x_scale=[0.1, 0.1, 0.1, 0.1],
        diff_step=1e-5,
    )
    assert memory.costs[NOW] == pytest.approx(by_scipy.cost, abs=0.01)  # of half a chi-squared
    curvature = np.linalg.pinv(by_scipy.jac.T @ by_scipy.jac)
    off = fit.atoms[0, :4] - by_scipy.x
    assert off @ np.linalg.solve(curvature, off) < 0.1  # deviations, squared
    hessian = memory.hessian[NOW, : PARAMETERS**2].reshape(PARAMETERS, -1)[:4, :4]
    assert hessian == pytest.approx(
        by_scipy.jac.T @ by_scipy.jac, rel=0.1, abs=0.02 * hessian.max()
    )


def drawn(fitter: Prepared, fit: Any, readings: Floats, count: int) -> tuple[Floats, Floats]:
    """Samples (C, 4) of a ball about a minimum, wider than it, and their log-weights."""
    from scipy.stats import multivariate_t

    rng = np.random.default_rng(5)
    inner = np.linalg.inv(
        fitter.memory.hessian[NOW, : PARAMETERS**2].reshape(PARAMETERS, -1)[:4, :4]
    )
    freedom = 5.0  # Student's t: heavier tails than what is sampled
    normal = rng.normal(size=(count, 4))
    chi = rng.chisquare(freedom, size=count) / freedom
    middle = fit.atoms[0, :4]
    samples = middle + (normal / np.sqrt(chi)[:, None]) @ np.linalg.cholesky(1.5 * inner).T
    proposal = multivariate_t(middle, 1.5 * inner, freedom).logpdf(samples)
    family = int(fit.family[0])
    cost = [0.5 * np.square(residuals(fitter, readings, atom, family)).sum() for atom in samples]
    return samples, -np.array(cost) - proposal


@pytest.mark.parametrize(
    ("place", "seed"), [(PLACE, 3), ((-9e-3, 3e-3), 8)], ids=["between", "beside"]
)
def test_evidence_and_covariance_are_those_of_samples(
    fitters: dict[str, Prepared], place: tuple[float, float], seed: int
) -> None:
    """Importance sampling of all four parameters against Laplace and against the walk.

    The walk is of flat ends, too, and so wider than the samples, which are of balls alone.
    """
    fitter, readings = fitters["capacitance"], noisy("capacitance", seed, place)
    fit = cold(fitter, readings)
    assert fit.family.tolist() == [BALL]
    samples, log_weight = drawn(fitter, fit, readings, 1500)
    highest = log_weight.max()
    weight = np.exp(log_weight - highest)
    assert weight.sum() ** 2 / np.square(weight).sum() > 100  # effective samples
    places = fitter.fitter.fit_model.places
    area = float(np.prod(places[1] - places[0]))
    prior = -np.log(area * LOG_FORCES * CURVATURE_STD) - 0.5 * np.log(2 * np.pi)
    evidence = highest + np.log(weight.mean()) + prior
    assert fit.evidence == pytest.approx(evidence, abs=0.5)
    weight /= weight.sum()
    mean = weight @ samples
    spread = np.sqrt(weight @ np.square(samples - mean))
    wider = np.sqrt(np.diag(fit.covariance[0])[:3]) / spread[:3]
    assert wider.min() > 0.9
    assert wider.max() < 1.5
    off = fit.atoms[0, :3] + fit.offsets[0, :3] - mean[:3]
    assert np.abs(off).max() < 0.5 * spread[:3].max()


def test_more_is_never_worse_and_nothing_is_left_out(fitters: dict[str, Prepared]) -> None:
    """Two balls 19 mm apart: each atom lowers the cost, the search keeps both."""
    readings = noisy("stress", 4, (-9e-3, 3e-3)) + truth(BALL_6, (1e-2, 2e-3), "stress")
    fitter, single = fitters["stress"], fitter_of("stress", most_contacts=1)
    both = cold(fitter, readings)
    cost, threshold = float(fitter.memory.costs[NOW]), fitter.fitter.threshold
    one = cold(single, readings)
    assert len(both.atoms) == 2
    assert len(one.atoms) == 1
    memory = single.memory
    white = memory.taxels[WHITE]
    nothing = np.square(readings * white).sum()
    nothing -= memory.sums[SHARED] * float(np.square(white) @ readings) ** 2
    assert cost + threshold < memory.costs[NOW] < 0.5 * nothing
    assert both.evidence > one.evidence > -0.5 * nothing
    fitter.fit(readings)
    assert fitter.memory.costs[NOW] == pytest.approx(cost, abs=0.05)


@pytest.mark.parametrize("name", list(NOISE))
def test_noise_alone_is_seldom_taken_for_a_contact(fitters: dict[str, Prepared], name: str) -> None:
    """4000 idle readings at 1e-3: 4 are expected at most, 12 would be one chance in a thousand."""
    rng = np.random.default_rng(6)
    seen = 0
    for _ in range(4000):
        readings = rng.normal(scale=NOISE[name], size=len(PATCH))
        seen += len(cold(fitters[name], readings).atoms) > 0
    assert seen <= 11


def test_the_stated_rate_sets_the_threshold(fitters: dict[str, Prepared]) -> None:
    """At a rate a hundred times higher, weaker touches are found; idle ones more often, too."""
    bold, careful = fitter_of("stress", false_alarm_rate=0.1), fitters["stress"]
    assert bold.fitter.threshold < careful.fitter.threshold
    rng = np.random.default_rng(7)
    idle = rng.normal(scale=NOISE["stress"], size=(600, len(PATCH)))
    seen = sum(len(cold(bold, readings).atoms) > 0 for readings in idle)
    assert 1 <= seen <= 85  # 60 and three deviations


def test_fields_are_drawn_when_they_are_used(fitters: dict[str, Prepared]) -> None:
    fitter = fitter_of("capacitance")
    fit = cold(fitter, noisy("capacitance", 4))
    assert len(fitter.operator.contacts(fit.solution)) == 1
    assert "_fine" not in vars(fitter.operator.renderer)  # displacements are not tabulated
    assert fitter.operator.displacement(fit.solution).any()
    idle = fitter.fit(np.zeros(len(PATCH))).solution
    assert fitter.data.fit.explained
    assert not fitter.operator.contacts(idle)
    assert not idle.pressure.any()


def test_all_that_is_searched_is_compiled_once(fitters: dict[str, Prepared]) -> None:
    for name, fitter in fitters.items():
        fitter.fit(noisy(name, 1))
        fitter.fit(noisy(name, 1, (2e-3, -5e-3)) + noisy(name, 3))
        fitter.data.reset()
    assert len(answer_reading.signatures) == 1
