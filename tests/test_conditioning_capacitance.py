"""Parallel plates, eq. (1) and (2)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinfield.elastic import Layer
from skinfield.errors import InputError
from skinfield.signal import rest_capacitance, strain_from_relative_capacitance


def test_the_paper_pad_has_a_sixth_of_a_picofarad():
    # 8.8541878128e-12 * 3 * pi * (2e-3)^2 / 2e-3, by hand
    assert rest_capacitance(Layer(), 4e-3) == pytest.approx(1.66897e-13, rel=1e-5)
    with pytest.raises(InputError, match="pad_diameter is -1"):
        rest_capacitance(Layer(), -1)


@given(st.floats(-5.0, 0.999))
def test_strain_is_that_of_a_plate_that_came_nearer(strain):
    rest, now = (rest_capacitance(Layer(thickness=h), 4e-3) for h in (0.1, 0.1 * (1 - strain)))
    change = (now - rest) / rest
    assert strain_from_relative_capacitance(change) == pytest.approx(strain, rel=1e-9, abs=1e-12)


def test_invalid_stays_invalid_and_nonsense_is_refused():
    assert np.isnan(strain_from_relative_capacitance([0.1, np.nan])).tolist() == [False, True]
    with pytest.raises(InputError, match=r"relative_capacitance\[0\] is -1.0.*cannot lose"):
        strain_from_relative_capacitance([-1.0])
