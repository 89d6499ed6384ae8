"""Millimetres for metres, kilopascals for pascals, counts for ΔC/C₀: refused at once, in words."""

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import InputError

PATCH = sf.layouts.hexagon72()


def test_a_patch_in_millimetres_is_refused() -> None:
    with pytest.raises(InputError, match="millimetres given as metres"):
        sf.Patch(1e3 * PATCH.positions, pad_diameter=4.0)


@pytest.mark.parametrize(
    ("layer", "words"),
    [
        (sf.Layer(thickness=0.5), r"thickness is 0.5 m, expected 2e-05 to 0.2 m: 2 mm is 2e-3"),
        (sf.Layer(thickness=2e-6), r"thickness is 2e-06 m"),
        (sf.Layer(young_modulus=150.0), r"is 150 Pa, expected 500 to 5e\+08 Pa: 150 kPa is 150e3"),
        (sf.Layer(young_modulus=150e9), r"is 1.5e\+11 Pa"),
    ],
)
def test_a_layer_in_other_units_is_refused(layer: sf.Layer, words: str) -> None:
    with pytest.raises(InputError, match=words):
        sf.Reconstructor(PATCH, layer)


def test_counts_as_readings_are_refused() -> None:
    with pytest.raises(InputError, match="counts need a calibration"):
        sf.Reconstructor(PATCH)(np.full(72, 240.0))


def test_skins_that_there_are_are_taken() -> None:
    for thickness in (0.1e-3, 50e-3):
        sf.Detector(PATCH, sf.Layer(thickness, 5e3))
