"""Resolution matrices of solvers against readings inverted one by one, and known spreads."""

from typing import Any

import numpy as np
import pytest

from skinfield.errors import Floats, InputError
from skinfield.figures.resolution import draw_spread, draw_spread_metrics
from skinfield.inverse import Fit, GaussianField, PseudoInverse, Tikhonov
from skinfield.layout import Grid, Patch
from skinfield.layout.generators import icub_triangle
from skinfield.mechanics import BondedLayer, Layer
from skinfield.observation import BaseStress, ObservationModel
from skinfield.resolution import ResolutionMatrix, resolution_matrix

LAYER = Layer(2e-3, 150e3, 0.5)


def model(nodes: int = 12) -> ObservationModel:
    patch = icub_triangle()
    return ObservationModel.of(
        patch, LAYER, Grid.square(patch, nodes), BondedLayer(), BaseStress(), 400.0
    )


@pytest.mark.parametrize("solver", [GaussianField(), Tikhonov(), PseudoInverse()])
def test_point_spread_is_what_a_load_on_one_node_becomes(
    solver: GaussianField | Tikhonov | PseudoInverse,
) -> None:
    observed = model()
    found, inverse = resolution_matrix(observed, solver), solver.prepare(observed)
    estimate = np.empty(len(observed.grid))
    for node in (0, 40, 77):
        load = np.zeros(len(observed.grid))
        load[node] = 1.0
        inverse.apply(observed.matrix @ load, estimate)
        np.testing.assert_allclose(found.point_spread(node), estimate, atol=1e-12)
        assert found.cross_talk(node)[3] == pytest.approx(found.point_spread(3)[node])


def test_as_many_taxels_as_nodes_and_no_noise_resolve_everything() -> None:
    patch = Patch(Grid.square(icub_triangle(), 5).plane)
    grid = Grid.square(patch, 5)
    observed = ObservationModel.of(patch, LAYER, grid, BondedLayer(), BaseStress(), 1e-3)
    found = resolution_matrix(observed, PseudoInverse())
    np.testing.assert_allclose(found.matrix, np.eye(25), atol=1e-6)
    for metrics in (found.spread_metrics(), found.cross_talk_metrics()):
        np.testing.assert_allclose(metrics.peak_error, 0.0)
        np.testing.assert_allclose(metrics.centre_error, 0.0, atol=1e-7)
        np.testing.assert_allclose(metrics.dispersion, 0.0, atol=1e-6)
        np.testing.assert_allclose(metrics.relative_amplitude, 1.0, rtol=1e-6)
        np.testing.assert_allclose(metrics.recovered, 1.0, rtol=1e-6)


def by_loops(plane: Floats, column: Floats, node: int) -> tuple[float, float, float]:
    """Peak error, error of the centre, dispersion, as MNE-Python defines them."""
    size = np.abs(column)
    peak = plane[size.argmax()]
    centre = sum(w * p for w, p in zip(size, plane, strict=True)) / size.sum()
    square = sum(w**2 * ((p - plane[node]) ** 2).sum() for w, p in zip(size, plane, strict=True))
    spread = np.sqrt(square / (size**2).sum())
    return (
        float(np.linalg.norm(peak - plane[node])),
        float(np.linalg.norm(centre - plane[node])),
        float(spread),
    )


def test_metrics_are_those_of_the_definitions() -> None:
    found = resolution_matrix(model(), Tikhonov())
    spread, leak = found.spread_metrics(), found.cross_talk_metrics()
    plane = found.grid.plane
    for node in (3, 50, 91):
        for metrics, function in (
            (spread, found.point_spread(node)),
            (leak, found.cross_talk(node)),
        ):
            expected = by_loops(plane, function, node)
            got = (metrics.peak_error, metrics.centre_error, metrics.dispersion)
            np.testing.assert_allclose([part[node] for part in got], expected, rtol=1e-9)
            assert metrics.recovered[node] == pytest.approx(function.sum())
    assert spread.relative_amplitude.max() == 1.0


def test_a_shift_by_one_cell_is_measured_as_one_pitch() -> None:
    grid = model(4).grid
    shifted = np.roll(np.eye(16), 1, axis=0)  # a load on node j is found on node j + 1
    metrics = ResolutionMatrix(grid, shifted).spread_metrics()
    inner = np.arange(15) % 4 != 3
    for part in (metrics.peak_error, metrics.centre_error, metrics.dispersion):
        np.testing.assert_allclose(part[:15][inner], grid.pitch)
    blind = ResolutionMatrix(grid, np.zeros((16, 16))).spread_metrics()
    assert np.isinf(blind.peak_error).all()
    assert (blind.recovered == 0).all()


class Finder:
    """A solver that is not linear, in name only."""

    def prepare(self, model: ObservationModel) -> Any:
        return self

    def fit(self, readings: Floats, deadline_ns: int | None = None) -> Fit:
        raise NotImplementedError

    def reset(self) -> None:
        raise NotImplementedError


def test_pictures_hold_what_was_found() -> None:
    found = resolution_matrix(model(), Tikhonov())
    spread = draw_spread(found, 40)
    shown = [axes.images[0].get_array() for axes in spread.axes if axes.images]
    assert shown[0] is not None
    np.testing.assert_allclose(np.ravel(shown[0]), found.point_spread(40))
    metrics = draw_spread_metrics(found.spread_metrics())
    assert len([axes for axes in metrics.axes if axes.images]) == 4


def test_bad_input_is_named() -> None:
    with pytest.raises(InputError, match="expected a linear one"):
        resolution_matrix(model(), Finder())
    found = ResolutionMatrix(model(4).grid, np.eye(16))
    for node in (-1, 16):
        with pytest.raises(InputError, match="node is"):
            found.point_spread(node)
    with pytest.raises(InputError, match="matrix has shape"):
        ResolutionMatrix(model(4).grid, np.eye(3))
