"""Parallel plates, eq. (1) and (2), and the paper's converter."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinfield.elastic import Layer
from skinfield.errors import InputError
from skinfield.signal import (
    CapacitanceConverter,
    capacitance_from_gap,
    gap_from_capacitance,
    pad_area,
    relative_capacitance_from_strain,
    rest_capacitance,
    strain_from_relative_capacitance,
)

PAD = {"area": pad_area(4e-3), "relative_permittivity": 3.0}
gaps = st.floats(1e-5, 1e-1)


def test_the_paper_pad_has_a_sixth_of_a_picofarad():
    # 8.8541878128e-12 * 3 * pi * (2e-3)^2 / 2e-3, by hand
    assert rest_capacitance(Layer(), 4e-3) == pytest.approx(1.66897e-13, rel=1e-5)


@given(gaps)
def test_gap_and_capacitance_undo_each_other(gap):
    assert gap_from_capacitance(capacitance_from_gap(gap, **PAD), **PAD) == pytest.approx(gap)


@given(st.floats(-5.0, 0.999))
def test_strain_and_relative_capacitance_undo_each_other(strain):
    change = relative_capacitance_from_strain(strain)
    assert strain_from_relative_capacitance(change) == pytest.approx(strain, rel=1e-9, abs=1e-12)


@given(st.floats(-0.5, 0.9))
def test_relative_capacitance_is_the_change_of_eq_1_over_its_value_at_rest(strain):
    rest, now = (capacitance_from_gap(2e-3 * (1 - v), **PAD) for v in (0.0, strain))
    change = float((now - rest) / rest)
    assert relative_capacitance_from_strain(strain) == pytest.approx(change, rel=1e-6, abs=1e-12)


def test_uniform_strain_gives_the_series_of_its_powers():
    v = 0.01
    series = v + v**2 + v**3
    assert relative_capacitance_from_strain(v) == pytest.approx(series, abs=2 * v**4)


def test_invalid_stays_invalid_and_nonsense_is_refused():
    assert np.isnan(capacitance_from_gap([2e-3, np.nan], **PAD)).tolist() == [False, True]
    with pytest.raises(InputError, match=r"gap\[1\] is 0.0"):
        capacitance_from_gap([2e-3, 0.0], **PAD)
    with pytest.raises(InputError, match="electrodes touch"):
        relative_capacitance_from_strain(1.0)
    with pytest.raises(InputError, match="cannot lose"):
        strain_from_relative_capacitance([-1.0])
    with pytest.raises(InputError, match="diameter is -1"):
        pad_area(-1)


@given(st.floats(0.0, 19e-12))
def test_converter_is_right_to_half_a_step_within_its_range(capacitance):
    cdc = CapacitanceConverter()
    counts = cdc.counts_from_capacitance(capacitance)
    assert counts == np.rint(counts)
    assert not cdc.saturated(counts)
    assert abs(cdc.capacitance_from_counts(counts) - capacitance) <= cdc.step / 2 * (1 + 1e-9)


def test_converter_clamps_and_says_so():
    cdc = CapacitanceConverter(parasitic=0.0)
    counts = cdc.counts_from_capacitance([1e-12, 4e-12, 17e-12, 30e-12, 99e-12, np.nan])
    assert cdc.highest == 81  # 26 pF / 0.32 pF
    assert counts[:5].tolist() == [0, 0, 41, 81, 81]
    assert np.isnan(counts[5])
    assert cdc.saturated(counts).tolist() == [True, True, False, True, True, False]


def test_the_printed_step_is_too_coarse_for_the_pad_and_it_is_said():
    rest = rest_capacitance(Layer(), 4e-3)
    assert CapacitanceConverter().relative_step(rest) == pytest.approx(1.917, rel=1e-3)
    pressed = CapacitanceConverter().counts_from_capacitance(rest * np.array([1.0, 1.3]))
    assert pressed[0] == pressed[1]  # 30 % more capacitance, and no count moves
    fine = CapacitanceConverter(low=0.0, high=16e-12, step=16e-12 / 65536, parasitic=0.0)
    moved = fine.counts_from_capacitance(rest * 1.3) - fine.counts_from_capacitance(rest)
    assert moved == pytest.approx(0.3 * fine.gain(rest), abs=1.0)


def test_converter_refuses_picofarads():
    with pytest.raises(InputError, match="4 pF is 4e-12"):
        CapacitanceConverter(low=4.0, high=30.0)
