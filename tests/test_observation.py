"""What taxels read: three quantities, against each other and against independent sums."""

import numpy as np
import pytest

from skinfield.elastic import (
    BaseStress,
    BondedLayer,
    Capacitance,
    Deformation,
    Gap,
    HalfSpace,
    Layer,
    ObservationModel,
)
from skinfield.elastic.electrostatics import GapStrain, _series, _Waves, capacitance_change
from skinfield.errors import InputError
from skinfield.simulate import Sphere, press
from skinfield.skin import Grid, Patch
from skinfield.skin.generators import cylinder, hexagon72

LAYER = Layer(2e-3, 100e3, 0.5)
FOAM = Layer(2e-3, 100e3, 0.3)
DOT = Patch(np.zeros((1, 2)))
WIDE = Grid.window(DOT, (-0.04, -0.04), (0.04, 0.04), pitch=1e-3)


def uniform(quantity: BaseStress | Gap | Capacitance, layer: Layer) -> float:
    """Reading per Pa of a pressure that is uniform over 80 mm."""
    return float(quantity.matrix(BondedLayer(), layer, WIDE, DOT.plane, 4e-3).sum())


def test_under_uniform_pressure_the_stress_is_the_pressure() -> None:
    assert uniform(BaseStress(), LAYER) == pytest.approx(1.0, rel=1e-6)
    assert uniform(BaseStress(pad_averaged=False), LAYER) == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("quantity", [Gap(), Gap(pad_averaged=False), Capacitance()])
def test_under_uniform_pressure_an_incompressible_gap_stays(quantity: Gap | Capacitance) -> None:
    modulus = 100e3 * 0.7 / (1.3 * 0.4)  # of a foam in uniaxial strain
    assert uniform(quantity, LAYER) * 1e5 == pytest.approx(0.0, abs=1e-6)
    assert uniform(quantity, FOAM) == pytest.approx(1 / modulus, rel=1e-5)


def test_a_gap_reads_negative_beside_a_contact_and_stress_does_not() -> None:
    beside = np.array([[4e-3, 0.0]])
    press = Grid(DOT, (1, 1), 2e-3)
    assert Gap().matrix(BondedLayer(), LAYER, press, beside, 4e-3) < 0
    assert Capacitance().matrix(BondedLayer(), LAYER, press, beside, 4e-3) < 0
    assert BaseStress().matrix(BondedLayer(), LAYER, press, beside, 4e-3) > 0


@pytest.mark.parametrize("mechanics", [BondedLayer(), HalfSpace(point_forces=False)])
@pytest.mark.parametrize(
    ("padded", "point"),
    [
        (BaseStress(), BaseStress(pad_averaged=False)),
        (Capacitance(), Capacitance(pad_averaged=False)),
        (Gap(), Gap(pad_averaged=False)),
    ],
)
def test_a_pad_reads_the_mean_of_its_points(
    mechanics: BondedLayer | HalfSpace,
    padded: BaseStress | Gap | Capacitance,
    point: BaseStress | Gap | Capacitance,
) -> None:
    grid = Grid.window(DOT, (-0.004, -0.003), (0.005, 0.006), pitch=1.5e-3)
    node, weight = np.polynomial.legendre.leggauss(40)
    radius, share = (node + 1) * 1e-3, weight * (node + 1) / 2  # of a pad 4 mm wide
    turn = 2 * np.pi * np.arange(96) / 96
    points = np.stack([np.outer(radius, np.cos(turn)), np.outer(radius, np.sin(turn))], -1)
    apart = point.matrix(mechanics, LAYER, grid, points.reshape(-1, 2), 4e-3)
    mean = share @ apart.reshape(40, 96, -1).mean(axis=1)
    whole = padded.matrix(mechanics, LAYER, grid, np.zeros((1, 2)), 4e-3)[0]
    assert mean == pytest.approx(whole, abs=1e-3 * np.abs(whole).max())


def flat_strain(value: float) -> GapStrain:
    return GapStrain(np.full((181, 181), value), np.full(2, -18e-3), 0.2e-3)


@pytest.mark.parametrize("value", [-0.1, 0.05, 0.2])
def test_a_uniform_gap_gives_the_series_of_a_plate_capacitor(value: float) -> None:
    for order in (1, 2, 3):
        read = capacitance_change(flat_strain(value), 2e-3, np.zeros((1, 2)), 4e-3, order)[0]
        # The sheet ends 18 mm away, where it springs back to its rest.
        assert read == pytest.approx(sum(value**n for n in range(1, order + 1)), rel=1e-4)


def test_a_ripple_of_the_gap_matches_perturbation_theory_to_second_order() -> None:
    # v = e cos(kx) on a periodic line: the charge's mean is S(0)[v D v] = e^2/2 kh coth(kh).
    step, waves, e = 0.2e-3, 6, 0.1
    x = np.arange(-300, 301) * step
    k = 2 * np.pi * waves / (601 * step)
    strain = GapStrain(np.tile(e * np.cos(k * x), (301, 1)), np.array([x[0], -30e-3]), step)
    series = _series(strain.values, 2, _Waves.of(strain, 2e-3)) - strain.values
    middle = series[150, 200:401]  # whole waves in the middle, away from the sheet's end
    expected = (e * np.cos(k * x[200:401])) ** 2 * k * 2e-3 / np.tanh(k * 2e-3)
    assert middle == pytest.approx(expected, abs=2e-3 * expected.max())


def test_the_first_term_of_a_press_is_the_matrix() -> None:
    patch = hexagon72()
    ball = Sphere(radius=6e-3, force=0.5, position=(1.2e-3, 0.4e-3))
    made = press(LAYER, [ball], extent=8e-3, cell=0.2e-3)
    matrix = Capacitance().matrix(BondedLayer(), LAYER, made.grid, patch.plane, 4e-3)
    linear = matrix @ made.pressure
    first = made.capacitance(patch.plane, 4e-3, order=1)
    assert first == pytest.approx(linear, abs=2e-3 * np.abs(linear).max())
    assert made.capacitance(patch.plane, 4e-3, order=3).max() > 1.1 * first.max()


def test_a_gap_that_closes_is_refused() -> None:
    with pytest.raises(InputError, match=r"indentation reaches 1\.20 of the thickness, expected"):
        flat_strain(1.2)


def test_linearised_capacitance_is_the_strain_of_a_uniform_gap() -> None:
    strain = np.array([-0.2, 0.0, 0.1, 0.5])
    out = np.empty(4)
    assert Capacitance().linearise(1 / (1 - strain) - 1, out) is out
    assert out == pytest.approx(strain)
    assert Capacitance(order=1).linearise(strain, out) is strain
    with pytest.raises(InputError, match="order is '4', expected one of 1, 2, 3"):
        Capacitance(order=4)


def test_deformation_is_the_sum_over_cells() -> None:
    patch = hexagon72()
    grid = Grid.square(patch, nodes=9)
    pressure = np.random.default_rng(0).normal(size=len(grid)) * 1e4
    offsets = (grid.plane[:, None] - grid.plane[None]).reshape(-1, 2)
    for mechanics in (BondedLayer(), HalfSpace()):
        response = mechanics.surface_displacement(LAYER, offsets, grid.pitch)[:, :, 2]
        expected = -np.einsum("klc,l->kc", response.reshape(81, 81, 3), pressure)
        found = Deformation(grid, LAYER, mechanics)(pressure)
        assert found == pytest.approx(expected, abs=1e-12)


def test_displacement_of_a_curved_patch_is_in_its_own_coordinates() -> None:
    patch = cylinder(radius=40e-3)
    grid = Grid.square(patch, nodes=15)
    plane = Grid(DOT, grid.shape, grid.pitch, grid.origin)
    for node in (112, 50):
        pressure = np.zeros(len(grid))
        pressure[node] = 1e4
        moved, flat = (Deformation(g, LAYER, BondedLayer())(pressure) for g in (grid, plane))
        along = -moved[node] @ grid.normals[node]
        assert along == pytest.approx(np.linalg.norm(moved[node]), rel=1e-3)
        turned = (grid.frames @ flat[:, :, None])[:, :, 0]
        np.testing.assert_allclose(moved, turned, atol=1e-9 * along)


def test_noise_must_be_positive_and_of_the_right_length() -> None:
    patch = hexagon72()
    grid = Grid.square(patch, nodes=5)

    def model(noise: object) -> ObservationModel:
        return ObservationModel.of(patch, LAYER, grid, BondedLayer(), BaseStress(), noise)

    above = r"\[0\] is 0.0, expected a finite number above 0"
    for noise, words in ((0.0, above), (np.ones(3), r" has shape \(3,\), expected \(72\)")):
        with pytest.raises(InputError, match="noise_std" + words):
            model(noise)
    part = model(np.arange(1.0, 73.0)).subset(np.arange(72) < 5)
    assert part.noise_std.tolist() == [1, 2, 3, 4, 5]
