"""The paper's equations, one by one, and the numbers of the authors' own program."""

import json

import numpy as np
import pytest
from closed_forms import point_displacement, point_traction

import skinfield as sf
from skinfield.elastic import HalfSpace, Layer
from skinfield.elastic.half_space import (
    coincident_displacement,
    exact_psi,
    fitted_psi,
    surface_displacement,
    virtual_depth,
)
from skinfield.lab import paper as paper_algorithm
from skinfield.solve import Inverse

E, H = 150e3, 2e-3
INTO = np.diag([1.0, 1.0, -1.0])  # the paper's z points into the skin in (15) to (19)
PLACES = np.array([[1e-3, 0.5e-3], [-0.2e-3, 3e-3], [7e-3, -4e-3]])
RNG = np.random.default_rng(2)
FORCE = np.array([0.3, -0.2, 0.9])  # N, z into the skin: pushing


def test_stress_8_9_11() -> None:
    for place, matrix in zip(PLACES, point_traction(PLACES, H), strict=True):
        r = np.array([*place, H])
        want = 3 / (2 * np.pi) * (FORCE @ r) * H / (r @ r) ** 2.5 * r
        np.testing.assert_allclose(INTO @ matrix @ INTO @ FORCE, want, rtol=1e-13)
    want = 3 * H**3 / (2 * np.pi * (np.sum(PLACES**2, axis=1) + H**2) ** 2.5)
    np.testing.assert_allclose(point_traction(PLACES, H)[:, 2, 2], want, rtol=1e-13)


@pytest.mark.parametrize("depth", [0.0, 0.4e-3, H])
def test_displacement_15_16(depth: float) -> None:
    for place, matrix in zip(PLACES, point_displacement(PLACES, depth, E, 0.5), strict=True):
        r, plane, normal = np.sqrt(place @ place + depth**2), FORCE[:2], FORCE[2]
        factor = 3 / (4 * np.pi * r * E)
        tangential = factor * (
            normal * place * depth / r**2 + plane + place * (plane @ place) / r**2
        )
        along = factor * (normal * (1 + depth**2 / r**2) + place @ plane * depth / r**2)
        got = INTO @ matrix @ INTO @ FORCE
        np.testing.assert_allclose(got, [*tangential, along], rtol=1e-13)


def test_effective_displacement_17_18_19_corrected() -> None:
    layer = Layer(H, E, 0.5)
    for place, matrix in zip(PLACES, surface_displacement(PLACES, layer), strict=True):
        away, plane, normal = np.sqrt(place @ place), FORCE[:2], FORCE[2]
        r, factor = np.hypot(away, H), 3 / (4 * np.pi * E)
        tangential = factor * (
            (plane + place * (plane @ place) / away**2) / away
            - (normal * place * H / r**2 + plane + place * (plane @ place) / r**2) / r
        )
        along = factor * (normal * (1 / away - (1 + H**2 / r**2) / r) - H * (place @ plane) / r**3)
        got = INTO @ matrix @ INTO @ FORCE
        np.testing.assert_allclose(got, [*tangential, along], rtol=1e-12)


def test_virtual_depth_20_spreads_the_force_to_its_mean_pressure() -> None:
    area = (2.5e-3) ** 2
    peak = point_traction(np.zeros((1, 2)), virtual_depth(area))[0, 2, 2]
    assert peak == pytest.approx(1 / area, rel=1e-14)


def test_coincident_25_26_and_psi() -> None:
    area = (2.5e-3) ** 2
    z0 = virtual_depth(area)
    own = coincident_displacement(Layer(H, E, 0.5), area, 0.25)
    want = 9 / (4 * np.pi * E * z0) * 0.25 * np.array([1, 1, 2])
    np.testing.assert_allclose(own, np.diag(want), rtol=1e-14)
    assert exact_psi(1e9) == pytest.approx(0.25, rel=1e-8)
    # "z0 << h in realistic situations" is not so at 20 x 20 nodes over 50 mm
    assert z0 == pytest.approx(1.73e-3, rel=1e-2)
    assert exact_psi(H / z0) == pytest.approx(0.134, abs=1e-3)


def lattice_patch() -> sf.Patch:
    rows, columns = np.divmod(np.arange(30), 6)
    x = columns * 5.0 + (rows % 2) * 2.5
    return sf.Patch(positions=np.column_stack([x, rows * 4.33]) * 1e-3)


@pytest.mark.parametrize("nodes", [10, 17])
def test_the_pipeline_is_the_papers_algorithm(nodes: int) -> None:
    reference, patch, layer = paper_algorithm, lattice_patch(), Layer(H, E, 0.5)
    grid = sf.Grid.square(patch, nodes)
    readings = RNG.normal(5e3, 2e3, len(patch))
    rec = sf.Reconstructor(
        patch,
        layer,
        grid,
        mechanics=HalfSpace(psi=0.25),
        quantity=sf.BaseStress(pad_averaged=False),
        solver=Inverse(),
        noise_std=100.0,
    )
    estimate = rec(readings)
    inside = grid.covered
    want = reference.reconstruct_as_paper(
        readings, patch.plane, grid.plane[inside], layer, grid.cell_area
    )
    force, moved = -estimate.force[:, 2], estimate.displacement[inside]
    np.testing.assert_allclose(force[inside], want.force, rtol=0, atol=1e-9 * want.force.max())
    assert (force[~inside] == 0).all()
    frames = np.einsum("nji,nj->ni", grid.frames[inside], moved)  # into the patch's own plane
    scale = 1e-9 * np.abs(want.normal).max()
    np.testing.assert_allclose(-frames[:, 2], want.normal, rtol=0, atol=scale)
    np.testing.assert_allclose(frames[:, :2], want.tangential, rtol=0, atol=scale)


class TestAuthorsProgram:
    """Fixtures of the authors' group: point forces, and Love's rectangle."""

    @pytest.fixture
    def bouss(self, shared_data):
        text = (shared_data / "contact-modelling-unige" / "boussinesq_fixture.json").read_text()
        return json.loads(text)

    @pytest.fixture
    def blocks(self, bouss):
        """Ours in their convention: (D, F, 3, 3), z into the skin, and where rule zz caps."""
        scalars, points = bouss["scalars"], bouss["points"]
        layer = Layer(scalars["skin_h"], scalars["skin_E"], scalars["skin_nu"])
        places, forces = (np.array(points[k]) for k in ("disps_source", "force_source"))
        sides = [float(v) for v in bouss["grid_values"]["force11_grid"]["cell"].split(",")]
        cell = np.sqrt(np.prod(sides))
        offset = (places[:, None] - forces[None]).reshape(-1, 2)
        model = HalfSpace(psi=fitted_psi, capped=True)
        delta = INTO @ (model.surface_displacement(layer, offset, cell) / cell**2) @ INTO
        own = coincident_displacement(layer, cell**2, fitted_psi(H / virtual_depth(cell**2)))
        shape = (len(places), len(forces))
        return (
            delta.reshape(*shape, 3, 3),
            (delta[:, 2, 2] == own[2, 2]).reshape(shape),
            layer,
            offset,
        )

    def matrices(self, blocks):
        delta, capped, layer, offset = blocks
        count = delta.shape[:2]
        # With a normal force alone, their tangential rows are capped by the normal one.
        free = np.zeros((len(offset), 3))
        apart = offset.any(axis=1)
        free[apart] = (INTO @ surface_displacement(offset[apart], layer) @ INTO)[:, :, 2]
        column = delta[..., 2].copy()
        column[..., :2] = np.where(capped[..., None], 0.0, free.reshape(*count, 3)[..., :2])
        return {
            "11": delta[..., 2, 2],
            "13": column.transpose(0, 2, 1).reshape(-1, count[1]),
            "31": delta[..., 2, :].reshape(count[0], -1),
            "33": delta.transpose(0, 2, 1, 3).reshape(3 * count[0], -1),
        }

    def test_scalars(self, bouss) -> None:
        scalars = bouss["scalars"]
        layer = Layer(scalars["skin_h"], scalars["skin_E"], scalars["skin_nu"])
        place = np.array([[scalars["x_for_bouss"], scalars["y_for_bouss"]]])
        delta = INTO @ surface_displacement(place, layer)[0] @ INTO
        want = [[scalars[f"bouss_{i}{j}_v"] for j in "xyz"] for i in "xyz"]
        np.testing.assert_allclose(delta, want, rtol=1e-12)
        assert virtual_depth(scalars["val_for_z0h"]) == pytest.approx(scalars["z0h_from_val"])
        assert fitted_psi(scalars["val_for_psi"]) == pytest.approx(
            scalars["psi_from_val"], rel=1e-12
        )
        area = scalars["s_for_appro"]
        own = coincident_displacement(
            layer, area, fitted_psi(layer.thickness / virtual_depth(area))
        )
        want = [scalars[f"appro_{i}{i}_v"] for i in "xyz"]
        np.testing.assert_allclose(np.diag(own), want, rtol=1e-12)

    @pytest.mark.parametrize("kind", ["11", "13", "31", "33"])
    def test_matrices(self, bouss, blocks, kind: str) -> None:
        ours = self.matrices(blocks)[kind]
        forces, places = kind
        theirs = np.array(bouss["matrices"][f"force{forces}_disps{places}"])
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12 * np.abs(theirs).max())
        inverse = np.array(bouss["matrices"][f"disps{places}_force{forces}"])
        scale = np.abs(inverse).max()
        np.testing.assert_allclose(np.linalg.pinv(ours), inverse, rtol=0, atol=1e-10 * scale)
        raw = bouss["raw_values"]
        moved = ours @ np.array(raw[f"force{kind}_grid"])
        np.testing.assert_allclose(
            moved, raw[f"disps{kind}_grid"], rtol=0, atol=1e-12 * np.abs(moved).max()
        )

    def test_loves_rectangles(self, shared_data) -> None:
        file = shared_data / "contact-modelling-unige" / "love_fixture.json"
        love = json.loads(file.read_text())
        scalars, points, values = love["scalars"], love["points"], love["grid_values"]
        places, loads = (np.array(points[k]) for k in ("disps_source", "press_source"))
        offset = (places[:, None] - loads[None]).reshape(-1, 2)
        layer = Layer(scalars["skin_h"], scalars["skin_E"], scalars["skin_nu"])
        half = scalars["dy"]
        assert scalars["dx"] == 2 * half  # a rectangle is two squares side by side
        ours = sum(
            HalfSpace(point_forces=False).indentation(
                layer, offset + np.array([side, 0.0]), 2 * half
            )
            for side in (half, -half)
        ).reshape(len(places), len(loads))
        np.testing.assert_allclose(ours, love["matrices"]["press2disps"], rtol=1e-12)
        np.testing.assert_allclose(
            np.linalg.pinv(ours), love["matrices"]["disps2press"], rtol=1e-11
        )
        pressure = np.array([*values["press_grid"]["values"].values()])
        np.testing.assert_allclose(
            ours @ pressure, [*values["disps_grid"]["values"].values()], rtol=1e-12
        )
