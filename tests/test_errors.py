"""Arguments: what becomes numbers, and what is refused with its name."""

import numpy as np
import pytest

from skinfield.errors import (
    InputError,
    as_floats,
    as_stamps,
    check_count,
    check_offers,
    check_positive,
    check_range,
    check_type,
)


def test_numbers_of_any_kind_become_floats_and_what_is_masked_is_nan():
    for values in ([1, 2], (1.0, 2.0), np.array([1, 2], np.uint8), np.array([1, 2], np.float32)):
        assert as_floats("x", values).dtype == np.float64
        assert as_floats("x", values).tolist() == [1.0, 2.0]
    hidden = np.ma.masked_array([1, 7, 3], mask=[False, True, False])
    assert as_floats("readings", hidden) == pytest.approx([1.0, np.nan, 3.0], nan_ok=True)


@pytest.mark.parametrize(
    "values", ["abc", [[1.0], [1.0, 2.0]], {"a": 1}, 1j, [1.0 + 0j], np.zeros(3, complex)]
)
def test_what_is_no_real_number_is_refused_by_name(values):
    with pytest.raises(InputError, match=r"readings is .*, expected numbers"):
        as_floats("readings", values)


def test_errors_of_long_values_stay_short():
    with pytest.raises(InputError) as error:
        as_floats("readings", np.zeros((40, 72), complex))
    assert len(str(error.value)) < 200


@pytest.mark.parametrize("value", ["x", None, 2**70, [1j], {}])
def test_what_is_no_time_is_refused_by_name(value):
    with pytest.raises(InputError, match=r"stamp_ns is .*, expected whole nanoseconds"):
        as_stamps("stamp_ns", value)


@pytest.mark.parametrize("value", ["a", None, [1.0], np.ones(2), {}, 0.0, np.nan, np.inf, True])
def test_what_is_no_number_above_zero_is_refused_by_name(value):
    with pytest.raises(InputError, match=r"(?s)pitch is .*, expected a finite number above 0"):
        check_positive("pitch", value, "side")
    if value is not True:
        with pytest.raises(InputError, match=r"(?s)share is .*, expected a number from 0.5 to 2"):
            check_range("share", value, 0.5, 2.0, "part")


@pytest.mark.parametrize("value", [2.5, "x", None, True, np.True_, 0, 9, np.nan])
def test_what_is_no_count_is_refused_by_name(value):
    with pytest.raises(InputError, match=r"starts is .*, expected a whole number from 1 to 8"):
        check_count("starts", value, 1, 8, "seeds")
    for good in (1, 8, np.int64(3), np.array(2)):
        check_count("starts", good, 1, 8, "seeds")


class Loud:
    volume = 11


def test_types_are_said_with_what_to_hand_in():
    with pytest.raises(InputError, match="n is 'a', expected an int: count them"):
        check_type("n", "a", int, "count them")
    with pytest.raises(InputError, match="box is 'a', expected a Loud: louder"):
        check_type("box", "a", Loud, "louder")
    check_type("box", Loud(), Loud, "louder")


def test_what_must_be_offered_is_named():
    check_offers("box", Loud(), ("volume",), "a box")
    with pytest.raises(InputError, match=r"box is the class Loud, .* an object: give Loud\(\)"):
        check_offers("box", Loud, ("volume",), "a box")
    with pytest.raises(InputError, match="box is 'loud', a string; hand in an object: a Loud"):
        check_offers("box", "loud", ("count", "volume"), "a Loud")
    with pytest.raises(InputError) as caught:
        check_offers("box", np.zeros((50, 50)), ("volume",), "a Loud")
    assert len(str(caught.value)) < 200
