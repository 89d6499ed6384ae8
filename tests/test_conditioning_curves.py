"""What a tensile test says."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from skinfield.errors import FileError, InputError
from skinfield.signal import initial_modulus, load_tensile_test


def rubber(strain, modulus=50e3):
    stretch = 1 + np.asarray(strain)
    return modulus / 3 * (stretch - stretch**-2)


def test_modulus_of_a_rubber_is_found_under_offset_and_scatter():
    strain = np.linspace(0.05, 0.5, 40)
    scatter = np.random.default_rng(0).standard_normal(40) * 200
    fit = initial_modulus(strain, rubber(strain) - 900 + scatter)
    assert fit.modulus == pytest.approx(50e3, abs=4 * fit.std)
    assert fit.offset == pytest.approx(-900, abs=400)
    assert fit.std < 1500
    with pytest.raises(InputError, match=r"2 points have a strain up to 0\.07"):
        initial_modulus(strain, rubber(strain), up_to=0.07)
    with pytest.raises(InputError, match="stress must rise"):
        initial_modulus(strain, -rubber(strain))


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
    assert fit.points == 20
