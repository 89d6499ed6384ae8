"""Model of a patch: as it is given, else as its calibration says, else as it usually is."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from skinfield.elastic import BondedLayer, Layer, Mechanics, Quantity, check_skin
from skinfield.errors import Floats, InputError, check_offers, check_type
from skinfield.reconstruct.diagnostics import Conditioner
from skinfield.signal import Calibration
from skinfield.skin import Grid, Patch, Skin

SOLVERS = (
    "a solver such as Auto() or GaussianField(); others are ContactFit(), NonNegative(), Sheet(), "
    "Tikhonov(), PseudoInverse() and Inverse()"
)


@dataclass(frozen=True, eq=False)
class PatchModel:
    """What the answers of a patch follow from.

    Attributes
    ----------
    calibration : Calibration or TouchCalibration, or None
    layer : Layer
    mechanics : Mechanics
    readings : function, or None
        From what is recorded, (L,) or (T, L), to readings; None where these are recorded.
    noise_std : float or (L,) array, in the quantity's unit
    relative : bool
        Whether forces hold up to one factor only.
    """

    calibration: Any
    layer: Layer
    mechanics: Mechanics
    readings: Callable[[Floats], Floats] | None
    noise_std: ArrayLike
    relative: bool

    @classmethod
    def of(
        cls,
        patch: Patch,
        calibration: Any,
        quantity: Quantity,
        layer: Layer | None = None,
        mechanics: Mechanics | None = None,
        relative: bool | None = None,
    ) -> "PatchModel":
        """See the class; raises InputError for parts that no skin has, or of another patch."""
        known = check_calibration(calibration, patch)
        layer = layer or getattr(known, "layer", None) or Layer()
        mechanics = mechanics or getattr(known, "mechanics", None) or BondedLayer()
        check_skin(patch, layer, mechanics, quantity)
        free = getattr(known, "relative", False) if relative is None else relative
        return cls(known, layer, mechanics, *_readings_from(known, quantity, layer), free)


def check_parts(solver: object, finder: object, grid: object) -> None:
    """Raise InputError, with what to hand in, for a part that is something else."""
    check_offers("solver", solver, ("prepare",), SOLVERS)
    check_offers("finder", finder, ("__call__",), "one such as ContactFinder()")
    if grid is not None:
        check_type("grid", grid, Grid, "such as Grid.square(patch, nodes=40)")


def check_calibration(calibration: Any, patch: Patch) -> Any:
    """Raise InputError for a calibration of another patch, or one that no reading comes from."""
    if calibration is None or isinstance(calibration, Calibration):
        if calibration is not None:
            calibration.check_patch(patch)
        return calibration
    if not hasattr(calibration, "readings"):
        name = type(calibration).__name__
        own = next((each for each in ("pressure", "force") if hasattr(calibration, each)), None)
        raise InputError(
            f"calibration is of {name}, expected one of counts or by touches, such as "
            "skinfield.load_calibration reads"
            + (f": this one answers by itself, calibration.{own}(counts)" if own else "")
        )
    if len(calibration) != len(patch):
        raise InputError(
            f"calibration has {len(calibration)} taxels, expected {len(patch)} as patch "
            f"{patch.name!r}: it belongs to another layout"
        )
    return calibration


def calibrations_of(skin: Skin, calibration: Any) -> dict[str, Any]:
    """Calibrations by the names of patches, of a mapping, or of one for the only patch."""
    names = [patch.name for patch in skin]
    if calibration is None:
        return {}
    if isinstance(calibration, Mapping):
        if unknown := sorted(set(calibration) - set(names)):
            raise InputError(
                f"calibration names {unknown[0]!r}, expected patches of the skin: "
                f"{', '.join(names)}"
            )
        return dict(calibration)
    if len(names) > 1:
        check_type("calibration", calibration, Mapping, f"by the names of {len(names)} patches")
    return {names[0]: calibration}


def _readings_from(
    calibration: Any, quantity: Quantity, layer: Layer
) -> tuple[Callable[[Floats], Floats] | None, ArrayLike]:
    """What turns recorded numbers into readings, if anything does; and their noise."""
    if calibration is None:
        return None, quantity.typical_noise
    if isinstance(calibration, Calibration):
        conditioner = Conditioner(quantity, layer, calibration)
        noise = conditioner.noise_in_quantity(calibration.quantity_std())
        return conditioner, np.where(np.isfinite(noise), noise, quantity.typical_noise)
    return calibration.readings, calibration.noise_std
