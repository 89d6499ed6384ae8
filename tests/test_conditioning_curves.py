"""Stress from strain and back, and what a tensile test says."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from skinfield.errors import FileError, InputError
from skinfield.signal import (
    LinearCurve,
    TableCurve,
    curve_from_tension,
    initial_modulus,
    load_tensile_test,
)


def rubber(strain, modulus=50e3):
    stretch = 1 + np.asarray(strain)
    return modulus / 3 * (stretch - stretch**-2)


@given(st.floats(1e3, 1e7), st.floats(-1, 1))
def test_line_both_ways(modulus, strain):
    curve = LinearCurve(modulus)
    assert curve.stress_from_strain(strain) == modulus * strain
    assert curve.strain_from_stress(modulus * strain) == pytest.approx(strain)


steps = st.lists(st.floats(1e-3, 1.0), min_size=1, max_size=12)


@settings(deadline=None)
@given(steps, st.data())
def test_table_both_ways_and_monotone(rises, data):
    strain = np.cumsum([0.0, *rises])
    stress = 1e4 * np.cumsum([0.0, *data.draw(st.permutations(rises))])
    curve = TableCurve(strain, stress)
    x = np.linspace(strain[0], strain[-1], 101)
    y = curve.stress_from_strain(x)
    assert (np.diff(y) > 0).all()
    np.testing.assert_allclose(curve.stress_from_strain(curve.strain_from_stress(y)), y, atol=1e-6)
    np.testing.assert_allclose(curve.stress_from_strain(strain), stress, atol=1e-9)


def test_table_is_near_a_smooth_law_between_its_points():
    strain = np.linspace(0, 0.5, 26)
    curve = TableCurve(strain, rubber(strain))
    x = np.linspace(0, 0.5, 999)
    assert np.abs(curve.stress_from_strain(x) - rubber(x)).max() < 2e-3 * rubber(0.5)


def test_table_does_not_extrapolate_nor_take_falling_data():
    curve = TableCurve([0.0, 0.1, 0.2], [0.0, 5e3, 9e3])
    with pytest.raises(InputError, match=r"strain\[1\] is 0.3, expected 0 to 0.2"):
        curve.stress_from_strain([0.1, 0.3])
    with pytest.raises(InputError, match="stress is -1"):
        curve.strain_from_stress(-1.0)
    assert np.isnan(curve.stress_from_strain(np.nan))
    assert np.isnan(curve.strain_from_stress(np.nan))
    with pytest.raises(InputError, match=r"stress\[2\] is 4000 after 5000"):
        TableCurve([0.0, 0.1, 0.2], [0.0, 5e3, 4e3])
    with pytest.raises(InputError, match="stress has 2 values, expected 3"):
        TableCurve([0.0, 0.1, 0.2], [0.0, 5e3])


def test_modulus_of_a_rubber_is_found_under_offset_and_scatter():
    strain = np.linspace(0.05, 0.5, 40)
    scatter = np.random.default_rng(0).standard_normal(40) * 200
    fit = initial_modulus(strain, rubber(strain) - 900 + scatter)
    assert fit.modulus == pytest.approx(50e3, abs=4 * fit.std)
    assert fit.offset == pytest.approx(-900, abs=400)
    assert fit.std < 1500
    assert fit.strain_range == (0.05, 0.5)
    with pytest.raises(InputError, match=r"2 points have a strain up to 0\.07"):
        initial_modulus(strain, rubber(strain), up_to=0.07)
    with pytest.raises(InputError, match="stress must rise"):
        initial_modulus(strain, -rubber(strain))


def test_mirrored_tension_is_short_of_compression_by_twice_the_strain():
    strain = np.linspace(0.01, 1.0, 100)
    curve = curve_from_tension(strain, rubber(strain))
    for e in (0.02, 0.05, 0.1):
        assert curve.stress_from_strain(-e) == pytest.approx(-rubber(e), rel=1e-3)
        true_compression = -rubber(-e)
        assert curve.stress_from_strain(e) / true_compression == pytest.approx(1 - 2 * e, abs=0.03)
    with pytest.raises(InputError, match=r"expected -1 to 0\.1"):
        curve.stress_from_strain(0.11)


def test_noise_that_falls_is_ironed_out():
    strain = np.linspace(0.01, 0.6, 60)
    stress = rubber(strain) + np.random.default_rng(1).standard_normal(60) * 300
    curve = curve_from_tension(strain, stress)
    assert np.abs(curve.stress_from_strain(-strain[1:-1]) + rubber(strain[1:-1])).max() < 1000
    with pytest.raises(InputError, match="rises above zero at 0 points"):
        curve_from_tension(strain, -stress)
    with pytest.raises(InputError, match="where the test ends"):
        curve_from_tension(strain, stress, compression_to=0.9)


FILE = """Material;Jelly;;;
Speed (mm/min);450;;;
;;;;
Time (s);True Strain;True Stress (MPa);Engineering Strain;Engineering Stress (MPa)
0.3;0.065;0.0015;0.068;0.0014
0.4;0.086;0.0037;0.090;0.0034
"""


def test_table_file(tmp_path):
    file = tmp_path / "t.csv"
    file.write_text(FILE.replace("\n", "\r\n"))
    test = load_tensile_test(file)
    assert test.material == "Jelly"
    assert test.strain.tolist() == [0.068, 0.09]
    assert test.stress.tolist() == pytest.approx([1400, 3400])
    assert test.parameters["Speed (mm/min)"] == "450"
    file.write_text(FILE.replace("0.0034", "oops"))
    with pytest.raises(FileError, match=r"t.csv:6 has 'oops' in column 5"):
        load_tensile_test(file)
    file.write_text(FILE.replace("Engineering", "Imaginary"))
    with pytest.raises(FileError, match="no line with the titles"):
        load_tensile_test(file)
    with pytest.raises(FileError, match="cannot be read"):
        load_tensile_test(tmp_path)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=100)
@given(st.data())
def test_garbled_file_is_a_file_error_or_a_test(tmp_path, data):
    content = bytearray(FILE.encode())
    for _ in range(data.draw(st.integers(1, 5))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    file = tmp_path / "g.csv"
    file.write_bytes(bytes(content[: data.draw(st.integers(0, len(content)))]))
    try:
        test = load_tensile_test(file)
    except FileError:
        return
    assert len(test.strain) == len(test.stress) >= 2
    assert np.isfinite(test.stress).all()


def test_ecoflex_00_30(shared_data):
    test = load_tensile_test(shared_data / "elastomer-tensile" / "Ecoflex 00-30.csv")
    assert len(test.strain) == 705
    fit = initial_modulus(test.strain, test.stress)
    assert 45e3 < fit.modulus < 60e3
    assert fit.residual < 400
    curve = curve_from_tension(test.strain, test.stress)
    assert curve.stress_from_strain(-1.0) == pytest.approx(-29.7e3, rel=0.02)  # its line at 100 %
    back = curve.strain_from_stress(curve.stress_from_strain(0.08))
    assert back == pytest.approx(0.08, rel=1e-9)
