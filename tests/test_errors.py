"""Arguments: what becomes numbers, and what is refused with its name."""

import numpy as np
import pytest

from skinfield.errors import InputError, as_floats


def test_numbers_of_any_kind_become_floats():
    for values in ([1, 2], (1.0, 2.0), np.array([1, 2], np.uint8), np.array([1, 2], np.float32)):
        assert as_floats("x", values).dtype == np.float64
        assert as_floats("x", values).tolist() == [1.0, 2.0]


def test_what_a_masked_array_hides_is_nan():
    hidden = np.ma.masked_array([1, 7, 3], mask=[False, True, False])
    assert as_floats("readings", hidden) == pytest.approx([1.0, np.nan, 3.0], nan_ok=True)


@pytest.mark.parametrize(
    "values", ["abc", [[1.0], [1.0, 2.0]], {"a": 1}, 1j, [1.0 + 0j], np.zeros(3, complex)]
)
def test_what_is_no_real_number_is_refused_by_name(values):
    with pytest.raises(InputError, match=r"readings is .*, expected numbers"):
        as_floats("readings", values)
