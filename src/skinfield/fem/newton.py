"""Newton's method for a layer in touch with a body, at one load."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints
from skinfield.fem.law import Elasticity
from skinfield.fem.linear import free_unknowns
from skinfield.fem.shape import SmoothShape
from skinfield.fem.touch import Touch, bordered

ITERATIONS = 25
CLOSE = 1e-9  # of forces in E h² and of gaps in h


class NoBalance(Exception):
    """No equilibrium was found; the text says why."""


@dataclass(frozen=True, eq=False)
class Balance:
    """A layer in touch, in thicknesses and Young's moduli.

    Attributes
    ----------
    state : (unknowns,) array
    forces : (nodes,) array
        Vertical, of the body into the surface.
    depth : float
    """

    state: Floats
    forces: Floats
    depth: float

    @property
    def touching(self) -> NDArray[np.bool_]:
        """Nodes that touch, (nodes,)."""
        found = self.forces > 0
        found[0] = found[1]
        return found

    def towards(self, other: "Balance", share: float) -> "Balance":
        """A guess beyond `other` on the line through both."""
        state = other.state + share * (other.state - self.state)
        forces = np.maximum(other.forces + share * (other.forces - self.forces), 0.0)
        return Balance(state, forces, other.depth + share * (other.depth - self.depth))


@dataclass(frozen=True, eq=False)
class Newton:
    """What stays the same while the load grows.

    Parameters
    ----------
    law : Elasticity
    shape : SmoothShape
    """

    law: Elasticity
    shape: SmoothShape

    def solve(self, guess: Balance, force: float | None) -> Balance:
        """Equilibrium at a given force, or at the depth of the guess.

        Nodes come into touch and leave it between the steps (Hüeber and Wohlmuth, Comput. Methods
        Appl. Mech. Engrg. 194 (2005) 3147).

        Raises
        ------
        NoBalance
            If the steps do not end.
        """
        balance, touching = guess, np.flatnonzero(guess.touching)
        for _ in range(ITERATIONS):
            balance = self._step(balance, touching, force)
            touch = Touch.of(self.law.section, self.shape, balance.state, balance.depth)
            rest = self._unbalanced(balance, touch)
            chosen = np.flatnonzero(touch.chosen(balance.forces))
            if np.array_equal(chosen, touching) and rest < CLOSE:
                return balance
            if not len(chosen):
                raise NoBalance("the surface left the body")
            touching = chosen
        raise NoBalance(f"{ITERATIONS} steps of Newton's method were not enough")

    def _step(self, balance: Balance, touching: Ints, force: float | None) -> Balance:
        from scipy.sparse.linalg import splu

        mesh, free = self.law.section, free_unknowns(self.law.section)
        touch = Touch.of(mesh, self.shape, balance.state, balance.depth)
        held = np.zeros(len(balance.forces))
        held[touching] = balance.forces[touching]
        stiffness = (self.law.stiffness(balance.state) + touch.bending(held))[free][:, free]
        matrix = bordered(stiffness, touch.directions(touching)[free], force)
        right = np.concatenate([-self.law.forces(balance.state)[free], touch.gap[touching]])
        if force is not None:
            right = np.append(right, force)
        try:
            found = splu(matrix).solve(right)
        except RuntimeError:
            raise NoBalance("the stiffness became singular") from None
        step, forces = np.zeros(mesh.unknowns), np.zeros_like(held)
        step[free] = found[: len(free)]
        forces[touching] = found[len(free) : len(free) + len(touching)]
        share = self._longest(balance.state, step)
        sunk = float(found[-1]) if force else 0.0
        return Balance(
            balance.state + share * step,
            balance.forces + share * (forces - balance.forces),
            balance.depth + share * sunk,
        )

    def _longest(self, state: Floats, step: Floats) -> float:
        """Share of a step that turns no element inside out."""
        share = 1.0
        while not self.law.valid(state + share * step):
            share /= 2
            if share < 0.01:
                raise NoBalance("an element turned inside out")
        return share

    def _unbalanced(self, balance: Balance, touch: Touch) -> float:
        """Greatest force without a counterpart, or gap where there is touch."""
        rest = self.law.forces(balance.state) + touch.pushes(balance.forces)
        gaps = touch.gap[balance.touching]
        return float(max(np.abs(rest[free_unknowns(self.law.section)]).max(), np.abs(gaps).max()))
