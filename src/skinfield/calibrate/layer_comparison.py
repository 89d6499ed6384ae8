r"""Comparison of layers by touches: which thickness, Poisson's ratio or cover reads as a skin does.

A wrong layer leaves hardly a residual, as place, force and size of a contact make up for it; the
marginal likelihood of contacts that are fitted anew by each layer shows it (MacKay 2003,
Information Theory, chapter 28), by some nats a press. Touches over one taxel count as one together:
what its gain is off tells the same over and over. And no place tells more than a body does that is
unlike the model by chance, so its evidence for any layer over another ends at 12 to 1.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from skinfield.calibrate.by_touch import checked_presses
from skinfield.calibrate.touch_presses import Presses
from skinfield.elastic import BondedLayer, Capacitance, Layer, ObservationModel, Quantity
from skinfield.errors import Floats, InputError, Ints, as_floats, check_type
from skinfield.plot import Pictured, Place, drawing, number, plural
from skinfield.skin import Grid, Patch
from skinfield.solve import ContactFit
from skinfield.solve.atoms.mechanics_choice import UNLIKELY

FEWEST, ENOUGH = 3, 20  # touches: at least, and that tell any of the usual layers from another
SURE, HIGHEST = 0.95, 0.99  # probability, from which a layer is named; that is stated at most
RATIOS = (0.5, 0.45, 0.4)  # Poisson's: of rubber, of one that is soft or has bubbles, of a foam
UNLIKE_RATIO = 0.02  # by which another ratio differs from the stated one at least
THINNER, THICKER = 0.8, 1.25  # times the stated thickness
MOST_TOLD = 2.5  # ln odds by one place: more of them, and wrong layers are named too often
POOR = 0.1  # of what taxels read: a model error, beyond which no layer explains the touches
NODES = 8  # of the grid, which no evidence needs


class LayerModel(NamedTuple):
    """A layer that a skin may have, and how it is held.

    Attributes
    ----------
    name : str
        A noun phrase, as of "reads like a thickness of 1.6 mm".
    layer : Layer
    mechanics : BondedLayer
    """

    name: str
    layer: Layer
    mechanics: BondedLayer = BondedLayer()


def usual_layers(layer: Layer, mechanics: BondedLayer) -> tuple[LayerModel, ...]:
    """What a skin may have instead of what is stated: one thing is another at a time."""
    models = []
    for ratio in RATIOS:
        if abs(ratio - layer.poisson_ratio) > UNLIKE_RATIO:
            foam = " or less, as of a foam" if ratio == min(RATIOS) else ""
            other = replace(layer, poisson_ratio=ratio)
            models.append(LayerModel(f"a Poisson's ratio of {ratio:g}{foam}", other, mechanics))
    covered = not mechanics.inextensible_cover
    cover = "an inextensible cover" if covered else "no cover"
    models.append(LayerModel(cover, layer, replace(mechanics, inextensible_cover=covered)))
    for factor in (THINNER, THICKER):
        other = replace(layer, thickness=factor * layer.thickness)
        name = f"a thickness of {number(1e3 * other.thickness)} mm"
        models.append(LayerModel(name, other, mechanics))
    return tuple(models)


@dataclass(frozen=True, eq=False)
class LayerComparison(Pictured):
    """What touches say of H layers, the stated one first.

    Attributes
    ----------
    models : tuple of LayerModel
    evidence : (P, H) array
        Logarithm of the marginal likelihood of each touch, less that by the layer that explains it
        best.
    place : (P,) int array
        Taxel that reads each touch most.
    model_error : (H,) array
        Part of what taxels read, by which each is wrong: median over touches.
    force_ratio : (H,) array
        Forces by each over those by the stated one: median over touches. The modulus is the stated
        one in all of them.
    """

    models: tuple[LayerModel, ...]
    evidence: Floats
    place: Ints
    model_error: Floats
    force_ratio: Floats

    @property
    def probability(self) -> Floats:
        """Of each layer (H,), if the skin has one of them; the stated one is e² times as likely."""
        bounded = np.maximum(self.evidence, -MOST_TOLD)
        _, taxel, count = np.unique(self.place, return_inverse=True, return_counts=True)
        odds = (bounded / count[taxel, None]).sum(axis=0)
        odds[1:] += UNLIKELY
        shares = np.exp(odds - odds.max())
        return np.asarray(shares / shares.sum())

    @property
    def likely(self) -> tuple[LayerModel, ...]:
        """The fewest layers that have 0.95 of the probability together, the most probable first."""
        probability = self.probability
        order = np.argsort(-probability, kind="stable")
        count = int(np.searchsorted(np.cumsum(probability[order]), SURE)) + 1
        return tuple(self.models[k] for k in order[:count])

    @property
    def best(self) -> LayerModel:
        """The most probable one."""
        return self.models[int(np.argmax(self.probability))]

    @property
    def fits(self) -> bool:
        """Whether the stated layer is among the likely ones."""
        return self.models[0] in self.likely

    @property
    def verdict(self) -> str:
        """What was found, in a sentence."""
        likely, each = self.likely, self.probability
        total = sum(float(each[self.models.index(model)]) for model in likely)
        names = " or ".join(model.name for model in likely)
        share = "above 0.99" if total > HIGHEST else f"{total:.2f}"
        how = f"probability {share} over {plural(len(self.place), 'touch', 'touches')}"
        at = self.models.index(self.best)
        if len(likely) == 1 and self.fits:
            text = f"the skin reads as stated ({how})"
        elif self.fits:
            text = f"touches do not tell {names} from each other ({how}): add some, elsewhere"
        else:
            together = ", which read alike" if len(likely) > 1 else ""
            ratio = self.force_ratio[at]
            text = f"the skin does not read as stated, but like {names}{together} ({how})"
            if np.isfinite(ratio):
                text += f"; by {self.best.name} forces are {ratio:.2f} of those by what is stated"
        if self.model_error[at] > POOR:
            text += (
                f"; even so the readings are {self.model_error[at]:.0%} off: gains differ, or the "
                "skin is another still"
            )
        return text

    def to_rows(self) -> list[dict[str, Any]]:
        """One row per layer: name, probability, model error, ratio of forces; for a table."""
        rows = zip(self.models, self.probability, self.model_error, self.force_ratio, strict=True)
        return [
            {
                "layer": model.name,
                "thickness_mm": 1e3 * model.layer.thickness,
                "poisson": model.layer.poisson_ratio,
                "covered": model.mechanics.inextensible_cover,
                "probability": float(share),
                "model_error": float(error),
                "force_ratio": float(ratio),
            }
            for model, share, error, ratio in rows
        ]

    def plot(self, ax: Place = None) -> Any:
        """Draw the probability of each layer.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            To draw in. Default those of a new figure.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        InputError
            If `ax` is something else, or Matplotlib is not installed.
        """
        return drawing("skinfield.calibrate.plot:plot_layers")(self, ax)

    def _facts(self) -> Mapping[str, str]:
        return {"Layers compared": self.verdict} | {
            row["layer"]: f"probability {row['probability']:.2g}, model error "
            f"{row['model_error']:.1%}, forces {row['force_ratio']:.2f} of the stated layer's"
            for row in self.to_rows()
        }

    def __repr__(self) -> str:
        return f"LayerComparison({self.verdict})"


def compare_layers(
    patch: Patch,
    readings: ArrayLike,
    *,
    layer: Layer | None = None,
    mechanics: BondedLayer | None = None,
    others: Sequence[LayerModel] | None = None,
    quantity: Quantity | None = None,
    noise_std: ArrayLike | None = None,
) -> LayerComparison:
    """Compare the layer that is stated with others, by touches of which nothing is known.

    Each touch is fitted by each layer. A first one takes seconds for the tables of each layer, once
    per machine.

    Parameters
    ----------
    patch : Patch
        Of L taxels.
    readings : (T, L) array, in the quantity's unit
        Of touches of anything, three at least and better twenty, all over the patch; what is read
        between them is taken off. NaN where a taxel did not answer.
    layer : Layer, optional
        As stated. Default `Layer()`.
    mechanics : BondedLayer, optional
        As stated. Default `BondedLayer()`: no cover.
    others : sequence of LayerModel, optional
        What the skin may have instead. Default `usual_layers`: a Poisson's ratio of 0.5, 0.45 or
        0.4, a cover or none, 0.8 and 1.25 times the thickness.
    quantity : Quantity, optional
        What a reading is. Default `Capacitance()`.
    noise_std : float or (L,) array, optional
        Of one reading. Default as readings that follow each other differ.

    Raises
    ------
    InputError
        If there are too few touches, readings fall under them or do not tell their noise, no other
        layer is there to compare with, or arguments are of another kind or unit.
    """
    quantity, mechanics = quantity or Capacitance(), mechanics or BondedLayer()
    check_type("quantity", quantity, Quantity, "such as skinfield.elastic.Capacitance()")
    why = "as a cover is compared with none: BondedLayer()"
    check_type("mechanics", mechanics, BondedLayer, why)
    stated = LayerModel("what is stated", layer or Layer(), mechanics)
    others = usual_layers(*stated[1:]) if others is None else tuple(others)
    if not others:
        raise InputError("others is empty, expected one LayerModel or more to compare with")
    for each in others:
        check_type("others", each, LayerModel, "such as LayerModel('a foam', Layer(...))")
    table = as_floats("readings", readings)
    found = checked_presses(table, patch, quantity, noise_std, FEWEST, ENOUGH)
    models = (stated, *others)
    fits = [_fitted(model, found, patch, quantity) for model in models]
    evidence, error, force = (np.array(each).T for each in zip(*fits, strict=True))
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.where((force > 0.0) & (force[:, :1] > 0.0), force / force[:, :1], np.nan)
    seen = np.isfinite(ratio).any(axis=0)
    ratios = np.full(len(models), np.nan)
    ratios[seen] = np.nanmedian(ratio[:, seen], axis=0)
    place = np.nanargmax(found.readings, axis=1)
    best = evidence.max(axis=1, keepdims=True)
    return LayerComparison(models, evidence - best, place, np.median(error, axis=0), ratios)


def _fitted(
    model: LayerModel, found: Presses, patch: Patch, quantity: Quantity
) -> tuple[Floats, Floats, Floats]:
    """Evidence, model error and force in N of each press (P,), by one layer."""
    how = model.layer, Grid.square(patch, nodes=NODES), model.mechanics, quantity, found.noise_std
    operator = ContactFit(check_mechanics=False, warm=False).prepare(
        ObservationModel.of(patch, *how)
    )
    data, out = operator.data(), np.zeros((3, len(found.readings)))
    for row, (reading, noise) in enumerate(zip(found.readings, found.noise, strict=True)):
        heard = np.isfinite(reading)
        data.reset()
        np.copyto(data.noise, noise)
        operator.without(heard).solve(np.nan_to_num(reading), data, touched=True)
        evidence = data.fit.infer()
        force = data.rows["normal_force"][: data.count].sum()
        out[:, row] = evidence, data.fit.misfit, force
    return out[0], out[1], out[2]
