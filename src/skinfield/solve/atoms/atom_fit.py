"""Contacts of one reading as the fit found them: drawn, with their fields, when they are used."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skinfield.errors import Floats, Ints
from skinfield.estimate import Contact
from skinfield.solve.atoms.atom_readings import PARAMETERS
from skinfield.solve.atoms.render import AtomRenderer
from skinfield.solve.atoms.ring_source import Drawable, drawable
from skinfield.solve.atoms.rows_kernel import HIDDEN, ODD, ROUND
from skinfield.solve.atoms.table import RING


def _model_error(place: float, force: float) -> Floats:
    return np.diag(np.square([place, place, force, force, 0.0, 0.0]))


ROUND_ERROR, ODD_ERROR = _model_error(*ROUND), _model_error(*ODD)
HIDDEN_ERROR = _model_error(*HIDDEN)


@dataclass(frozen=True, eq=False)
class AtomFit:
    """What a contact fit makes of one reading; fields and contacts are drawn when they are used.

    Attributes
    ----------
    renderer : AtomRenderer
    thickness : float, m
    atoms, offsets : (N, 6) arrays
        At the minimum of the cost, and from there to the posterior's mean; see `fit_kernel`.
    covariance : (N, 6, 6) array
    family : (N,) int array
    model_error : float
        What the model is wrong by, as inferred: part of what taxels read.
    at_mean : bool
        Whether the mean is the answer: its error is smaller.
    predicted : (L,) array, in the quantity's unit
        What the taxels would read of them.
    offset : float, in the quantity's unit
        That all taxels are taken to share; it is part of what is predicted.
    evidence : float
        Logarithm of the marginal likelihood, up to a constant that all readings share.
    explained : bool
        Whether noise accounts for what the contacts leave over.
    notes : tuple of str
    """

    renderer: AtomRenderer
    thickness: float
    atoms: Floats
    offsets: Floats
    covariance: Floats
    family: Ints
    model_error: float
    at_mean: bool
    predicted: Floats
    offset: float
    evidence: float
    explained: bool
    notes: tuple[str, ...]

    def keep(self) -> "AtomFit":
        """Itself: nothing overwrites it."""
        return self

    @property
    def parameters(self) -> int:
        """Numbers that were fitted: four of each atom, six of a drawn-out one."""
        return int(4 * len(self.atoms) + 2 * np.any(self.atoms[:, 4:], axis=1).sum())

    @cached_property
    def drawn(self) -> Drawable | None:
        """Atoms as they are drawn; None without any."""
        if not len(self.atoms):
            return None
        atoms, covariance = np.empty_like(self.atoms), np.empty_like(self.covariance)
        for index, (atom, known) in enumerate(zip(self.atoms, self.covariance, strict=True)):
            odd = np.any(atom[4:]) or self.family[index] == RING
            error = known + (ODD_ERROR if odd else ROUND_ERROR) + HIDDEN_ERROR * self.model_error**2
            mean = atom + self.offsets[index] if self.at_mean else atom
            atoms[index], covariance[index] = stated(mean, error, self.thickness)
        return drawable(atoms, self.family, covariance, self.thickness)

    @cached_property
    def pressure(self) -> Floats:
        """Mean pressure on each cell, (K,) Pa."""
        out = np.zeros(len(self.renderer.grid))
        if len(self.atoms):
            self.renderer.pressure(*self._rendered, out)
        return out

    @cached_property
    def _rendered(self) -> tuple[Floats, Ints]:
        """Atoms in SI as they are drawn, without what a covariance takes, and their families."""
        if self.family.max() == RING:
            assert self.drawn is not None  # as there are atoms
            return self.drawn.atoms, self.drawn.family
        mean = self.atoms + self.offsets if self.at_mean else self.atoms
        out, half = np.empty_like(mean), mean[:, 4:]
        out[:, :2] = mean[:, :2] * self.thickness
        out[:, 2:4] = np.exp(mean[:, 2:4]) * (1.0, self.thickness)
        out[:, 4] = np.hypot(half[:, 0], half[:, 1]) * self.thickness
        out[:, 5] = np.arctan2(half[:, 1], half[:, 0])
        return out, self.family

    @cached_property
    def pressure_std(self) -> Floats:
        """One standard deviation of it, (K,) Pa."""
        out, drawn = np.zeros(len(self.renderer.grid)), self.drawn
        if drawn is not None:
            self.renderer.pressure_std(drawn.atoms, drawn.family, drawn.each, out)
        return out

    @cached_property
    def displacement(self) -> Floats:
        """Of the nodes in the patch's frame, (K, 3) m."""
        out = np.zeros((len(self.renderer.grid), 3))
        if self.drawn is not None:
            self.renderer.displacement(self.drawn.atoms, self.drawn.family, out)
        return out

    @cached_property
    def contacts(self) -> tuple[Contact, ...]:
        """By falling normal force."""
        drawn = self.drawn
        if drawn is None:
            return ()
        return self.renderer.contacts(drawn.atoms, drawn.family, drawn.covariance, drawn.groups)


def stated(atom: Floats, covariance: Floats, thickness: float) -> tuple[Floats, Floats]:
    """An atom and its covariance as x m, y m, force N, radius m, half-length m and angle rad."""
    half, angle = float(np.hypot(atom[4], atom[5])), float(np.arctan2(atom[5], atom[4]))
    force, radius = float(np.exp(atom[2])), float(np.exp(atom[3])) * thickness
    by = np.zeros((PARAMETERS, PARAMETERS))
    by[0, 0] = by[1, 1] = thickness
    by[2, 2], by[3, 3] = force, radius
    if half > 0.0:
        along, across = np.cos(angle), np.sin(angle)
        by[4, 4], by[4, 5] = thickness * along, thickness * across
        by[5, 4], by[5, 5] = -across / half, along / half
    place = atom[:2] * thickness
    return np.array([*place, force, radius, half * thickness, angle]), by @ covariance @ by.T
