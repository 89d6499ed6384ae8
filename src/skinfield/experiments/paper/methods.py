"""Methods that are compared: the paper's and ours, with either model of the elastomer."""

from dataclasses import dataclass

from skinfield.inverse import GaussianField, Inverse, PseudoInverse, Solver
from skinfield.layout import Grid, Patch
from skinfield.mechanics import BondedLayer, HalfSpace, Layer, Mechanics
from skinfield.observation import BaseStress, Capacitance, Quantity
from skinfield.pipeline import Reconstructor


@dataclass(frozen=True)
class Method:
    """A solver with what it assumes of elastomer and taxels.

    Parameters
    ----------
    name : str
    solver : Solver
    mechanics : Mechanics
    quantity : Quantity
        What it takes the readings to be.
    """

    name: str
    solver: Solver
    mechanics: Mechanics
    quantity: Quantity

    def prepared(self, patch: Patch, layer: Layer, nodes: int, noise_std: float) -> Reconstructor:
        """Reconstruction on `nodes` x `nodes`, as in the paper's figures."""
        return Reconstructor(
            patch,
            layer,
            Grid.square(patch, nodes=nodes),
            mechanics=self.mechanics,
            quantity=self.quantity,
            solver=self.solver,
            noise_std=noise_std,
        )


POINT = BaseStress(pad_averaged=False)
PRINTED = HalfSpace(psi=0.25)  # the paper's constant in (25) and (26), "in all the experiments"
PAPER = Method("paper: inverse, half-space", Inverse(), PRINTED, POINT)
PAPER_EXACT = Method("paper's inverse, exact Ψ", Inverse(), HalfSpace(), POINT)
PAPER_GENERAL = Method(
    "paper: pseudo-inverse, half-space", PseudoInverse(resample=True), PRINTED, POINT
)
PAPER_ON_LAYER = Method("paper's inverse, layer", Inverse(), BondedLayer(), POINT)
FIELD = Method("ours: Gaussian field, layer", GaussianField(), BondedLayer(), BaseStress())
FIELD_HALF_SPACE = Method("Gaussian field, half-space", GaussianField(), HalfSpace(), BaseStress())
FIELD_CHANGE = Method(
    "ours: Gaussian field, layer, capacitance", GaussianField(), BondedLayer(), Capacitance()
)
