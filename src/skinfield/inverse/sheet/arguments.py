"""What a sheet is told, checked before anything is computed of it."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    check_count,
    check_finite,
    check_offers,
    check_range,
    check_shape,
    check_type,
)
from skinfield.mechanics import Layer
from skinfield.observation.arguments import LAYER

NOISE = 1e-20, 1e12  # in any unit of a reading
LARGEST = 1e12  # deviations of the noise: their squares add up in single precision


def check_physics(layer: object, mechanics: object, quantity: object) -> None:
    """Raise InputError for what is no layer, elastomer or quantity."""
    check_type("layer", layer, Layer, LAYER)
    needs: tuple[str, ...] = ("surface_displacement", "indentation")
    check_offers("mechanics", mechanics, needs, "a model such as BondedLayer() or HalfSpace()")
    needs = ("matrix", "linearise", "typical_noise")
    check_offers("quantity", quantity, needs, "one of BaseStress(), Gap() and Capacitance()")


def check_settings(tolerance: float, most_iterations: int, precision: object) -> None:
    """Raise InputError for settings that no iteration could go by."""
    check_range("tolerance", tolerance, 1e-12, 0.5, "a share of the whitened readings")
    check_count("most_iterations", most_iterations, 1, 10_000, "some ten are usual")
    if precision not in (np.float32, np.float64):
        raise InputError(
            f"precision is {precision!r}, expected numpy.float32 or numpy.float64: the first is "
            "faster, the second for comparisons"
        )


def checked_places(positions: ArrayLike) -> Floats:
    """Positions (L, 2) of at least one taxel."""
    places = as_floats("positions", positions)
    check_shape("positions", places, (None, 2), "x and y of each taxel in the plane, in metres")
    if not len(places):
        raise InputError("positions has no taxel, expected at least one")
    check_finite("positions", places, "a taxel without a place reads nothing that is known")
    return places


def checked_noise(noise_std: ArrayLike, taxels: int) -> Floats:
    """One standard deviation per taxel, (L,)."""
    noise = as_floats("noise_std", noise_std)
    if noise.ndim == 0:
        noise = np.full(taxels, float(noise))
    check_shape("noise_std", noise, (taxels,), "one number, or one per taxel")
    for index in np.flatnonzero(~((noise >= NOISE[0]) & (noise <= NOISE[1])))[:1]:
        check_range(f"noise_std[{index}]", float(noise[index]), *NOISE, "no reading is exact")
    return noise


def check_like(name: str, array: NDArray[Any], precision: type[Any]) -> None:
    """Raise InputError unless an array is one that the kernels take as it is."""
    if array.dtype != precision or not array.flags.c_contiguous:
        raise InputError(
            f"{name} is of {array.dtype}, expected {np.dtype(precision)} in C order: what the "
            "sheet computes in is its precision"
        )


def check_readings(readings: Floats, noise_std: Floats, lowest: float) -> None:
    """Raise InputError for a reading that no skin gives; NaN stands for none."""
    for index in np.flatnonzero(np.abs(readings) > LARGEST * noise_std)[:1]:
        raise InputError(
            f"readings[{index}] is {readings[index]}, expected at most {LARGEST:g} times its "
            f"noise_std of {noise_std[index]:g}, or NaN for a taxel that did not answer"
        )
    for index in np.flatnonzero(readings <= lowest)[:1]:
        raise InputError(
            f"readings[{index}] is {readings[index]}, expected above {lowest:g}: no skin reads "
            "that; mark such taxels with NaN, and check the gain"
        )
