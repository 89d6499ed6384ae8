"""A ball that is pressed on and then pushed, with friction: a press beside finite elements.

The layer is a box of hexahedra (displacement of degree 2, pressure of degree 1), half of it, as the
push lies in its plane of symmetry; its faces far away are held. Unit forces on the nodes near the
ball give a flexibility, on which contact and Coulomb's friction are solved node by node
(Gauss-Seidel), first without friction and then in two steps of the push; or with friction from the
first touch on, in some steps: nothing is shared with the program. Lengths are in mm, forces in N.

    python benchmarks/friction_fem.py --element 0.68 --layers 3
    python benchmarks/friction_fem.py --from-touch 4
"""

import argparse
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import bmat, csc_matrix
from scipy.sparse.linalg import splu

from skinfield.elastic import Layer
from skinfield.lab.fem.mesh import scikit_fem
from skinfield.simulate import Sphere, press, press_path

HEIGHT, MODULUS, POISSON = 2.0, 0.1, 0.49999
BALL, FORCE, PUSH, FRICTION = 6.0, 1.0, 0.4, 0.6
FAR, CORE, NEAR = 11.0, 3.4, 3.3  # half the width, of even elements, and where the ball may touch
STEPS = 2


class Box(NamedTuple):
    """The layer: unknowns, where they are, and the factorised stiffness."""

    places: np.ndarray  # (3, unknowns) of the displacement
    component: np.ndarray
    pressure_places: np.ndarray
    free: np.ndarray
    factor: Any


def edges(element: float, coarse: int = 4) -> np.ndarray:
    """Even elements up to the core, then ever longer ones up to the far face."""
    inner = np.arange(0.0, CORE + element / 2, element)
    low, high = 1.0001, 4.0
    for _ in range(100):
        ratio = (low + high) / 2
        total = element * ratio * (ratio**coarse - 1) / (ratio - 1)
        low, high = (ratio, high) if total < FAR - inner[-1] else (low, ratio)
    return np.concatenate(
        [inner, inner[-1] + element * np.cumsum(ratio ** np.arange(1, coarse + 1))]
    )


def box(element: float, layers: int) -> Box:
    """Assemble and factorise."""
    fem, y = scikit_fem(), edges(element)
    z = HEIGHT * (1 - (1 - np.linspace(0, 1, layers + 1)) ** 1.3)
    mesh = fem.MeshHex.init_tensor(np.concatenate([-y[:0:-1], y]), y, z)
    moved = fem.Basis(mesh, fem.ElementVector(fem.ElementHex2()), intorder=4)
    pressure = moved.with_element(fem.ElementHex1())
    shear = MODULUS / (2 * (1 + POISSON))
    compliance = (1 + POISSON) * (1 - 2 * POISSON) / (POISSON * MODULUS)

    @fem.BilinearForm
    def strain(u, v, _):  # type: ignore[no-untyped-def]
        a, b = ((w.grad + np.swapaxes(w.grad, 0, 1)) / 2 for w in (u, v))
        return 2 * shear * np.einsum("ij...,ij...->...", a, b)

    @fem.BilinearForm
    def volume(u, q, _):  # type: ignore[no-untyped-def]
        return (u.grad[0, 0] + u.grad[1, 1] + u.grad[2, 2]) * q

    @fem.BilinearForm
    def bulk(p, q, _):  # type: ignore[no-untyped-def]
        return -compliance * p * q

    coupling = volume.assemble(moved, pressure)
    blocks = [[strain.assemble(moved), coupling.T], [coupling, bulk.assemble(pressure)]]
    places = moved.doflocs
    component = np.empty(moved.N, dtype=int)
    for each in (moved.nodal_dofs, moved.edge_dofs, moved.facet_dofs, moved.interior_dofs):
        component[each] = np.arange(3)[:, None]
    held = (places[2] == 0) | (np.abs(places[0]) > FAR - 1e-6) | (places[1] > FAR - 1e-6)
    held |= (places[1] == 0) & (component == 1)
    free = np.flatnonzero(np.concatenate([~held, np.ones(pressure.N, dtype=bool)]))
    stiffness = csc_matrix(bmat(blocks))[free][:, free].tocsc()
    # With a little compressibility it is quasi-definite: no pivots are needed.
    factor = splu(
        stiffness,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    return Box(places, component, pressure.doflocs, free, factor)


class Touch:
    """Nodes that may touch, (N, 2) mm, and what forces on them do."""

    def __init__(self, layer: Box) -> None:
        top = [
            {
                (round(x, 6), round(y, 6)): n
                for n, (x, y) in zip(found, layer.places[:2, found].T, strict=True)
                if np.hypot(x, y) < NEAR
            }
            for found in (
                np.flatnonzero((np.abs(layer.places[2] - HEIGHT) < 1e-9) & (layer.component == c))
                for c in range(3)
            )
        ]
        self.places = np.array(list(top[0]))
        unknowns = np.array([[top[c][place] for c in range(3)] for place in top[0]])
        count = len(unknowns)
        row = np.full(len(layer.component) + len(layer.pressure_places.T), -1)
        row[layer.free] = np.arange(len(layer.free))
        rows = row[unknowns.ravel()]
        self.states = np.zeros((len(layer.free), 3 * count), dtype=np.float32)
        flexibility = np.zeros((3 * count, 3 * count))
        moves = rows >= 0
        for column in np.flatnonzero(moves):
            unit = np.zeros(len(layer.free))
            unit[rows[column]] = 1.0
            state = layer.factor.solve(unit)
            self.states[:, column] = state
            flexibility[moves, column] = state[rows[moves]]
        self.flexibility = flexibility.reshape(count, 3, count, 3)
        self.own = np.array([self.flexibility[n, :, n] for n in range(count)])
        self.height = BALL - np.sqrt(BALL**2 - (self.places**2).sum(axis=1))
        base = (layer.pressure_places[2] == 0) & (layer.pressure_places[1] == 0)
        self.base = layer.pressure_places[0, base]
        self.base_rows = row[len(layer.component) + np.flatnonzero(base)]

    def base_stress(self, force: np.ndarray) -> np.ndarray:
        """Compression at `base`, MPa: of an incompressible layer the pressure there."""
        return np.asarray(-(self.states[self.base_rows].astype(float) @ force.ravel()))

    def settle(
        self,
        force: np.ndarray,
        depth: float,
        before: np.ndarray | None = None,
        push: float = 0.0,
        load: float = FORCE,
    ) -> tuple[np.ndarray, float, float, np.ndarray]:
        """Contact and friction in one step; forces (N, 3) on the skin, depth and slide."""
        moved = np.einsum("iajb,jb->ia", self.flexibility, force)
        slide = 0.2 * (push > 0)
        for _ in range(4000):
            old = force.copy()
            for n in range(len(force)):
                rest = moved[n, 2] - self.own[n, 2, 2] * force[n, 2]
                new = np.array([*force[n, :2], 0.0])
                new[2] = min((self.height[n] - depth - rest) / self.own[n, 2, 2], 0.0)
                if before is not None:
                    apart = before[n] + [slide, 0.0] - moved[n, :2]
                    new[:2] += apart / max(self.own[n, 0, 0], self.own[n, 1, 1])
                    new[1] *= self.own[n, 1, 1] > 0
                    size, limit = np.hypot(*new[:2]), -FRICTION * new[2]
                    new[:2] *= min(1.0, limit / max(size, 1e-300))
                if (new != force[n]).any():
                    moved += self.flexibility[:, :, n] @ (new - force[n])
                    force[n] = new
            lacking = load / 2 + force[:, 2].sum()
            depth += 0.36 * lacking / FORCE
            missing = 0.0 if before is None else push / 2 - force[:, 0].sum()
            slide += 0.42 * missing / FORCE
            change = np.abs(force - old).sum() / FORCE
            if max(change, abs(lacking), abs(missing)) < 1e-6:
                break
        return force, depth, slide, moved


def main() -> None:
    """Compare, and print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--element", type=float, default=0.68, help="size at the surface, mm")
    parser.add_argument("--layers", type=int, default=3, help="of elements")
    parser.add_argument("--from-touch", type=int, default=0, help="steps of a press with friction")
    chosen = parser.parse_args()
    touch = Touch(box(chosen.element, chosen.layers))
    force, depth, _, moved = touch.settle(np.zeros((len(touch.places), 3)), 0.6)
    alone, slid = depth, 0.0
    loads = FORCE * np.arange(1, chosen.from_touch + 1) / max(chosen.from_touch, 1)
    if chosen.from_touch:
        force[:], moved[:] = 0.0, 0.0
    for load in loads:
        before = moved[:, :2].copy()
        force, depth, _, moved = touch.settle(force, depth, before, load=load)
    plain, pressed_on = touch.base_stress(force), depth
    for step in range(1, STEPS + 1):
        before = moved[:, :2].copy()
        force, depth, slide, moved = touch.settle(force, depth, before, PUSH * step / STEPS)
        slid += slide
    pushed = touch.base_stress(force)
    layer = Layer(HEIGHT * 1e-3, MODULUS * 1e6, 0.5)
    ball = Sphere(radius=BALL * 1e-3, force=FORCE, shear=(PUSH, 0.0))
    still = Sphere(radius=BALL * 1e-3, force=FORCE)
    if chosen.from_touch:
        steps = [replace(still, force=load) for load in loads]
        steps += [replace(ball, shear=(PUSH * n / STEPS, 0.0)) for n in range(1, STEPS + 1)]
        path = press_path(layer, [[step] for step in steps], extent=20e-3, friction=FRICTION)
        start, ours = path[-STEPS - 1], path[-1]
        ours_slid = sum(each.translation[0, 0] for each in path[-STEPS:])
    else:
        start = press(layer, [still], extent=20e-3)
        ours = press(layer, [ball], extent=20e-3, friction=FRICTION)
        ours_slid = ours.translation[0, 0]
    line = np.column_stack([touch.base, 0 * touch.base]) * 1e-3
    stress = ours.base_stress(line, 0.0) * 1e-6
    change = stress - start.base_stress(line, 0.0) * 1e-6
    middle = (force[:, 2] @ touch.places[:, 0]) / force[:, 2].sum()
    ahead = ours.moment[1] / ours.force * 1e3
    rows = {
        "depth without friction, mm": (alone, press(layer, [still], 20e-3).approach[0] * 1e3),
        "depth before the push, mm": (pressed_on, start.approach[0] * 1e3),
        "depth, mm": (depth, ours.approach[0] * 1e3),
        "slide, mm": (slid, ours_slid * 1e3),
        "middle of the pressure ahead, mm": (middle, ahead),
    }
    print(f"{'':36}{'elements':>10}{'press':>10}")
    for name, (one, other) in rows.items():
        print(f"{name:36}{one:10.4f}{other:10.4f}")
    for name, one, other in (
        ("base stress", pushed, stress),
        ("its change by the push", pushed - plain, change),
    ):
        apart = np.linalg.norm(one - other) / np.linalg.norm(one)
        print(f"{name + ', apart':46}{apart:10.2%}")


if __name__ == "__main__":
    main()
