"""Scenarios of the rig: TOML both ways, and what is said of mistakes."""

import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skinfield as sf
from skinfield.elastic import Layer
from skinfield.errors import FileError
from skinfield.files.layouts.load import save_layout
from skinfield.lab.scenarios import load_scenario, scenario_from_toml, template
from skinfield.lab.scenarios.scenario import PARTS
from skinfield.lab.scenarios.table import key_of, si_from_value
from skinfield.simulate.electronics import (
    Electronics,
    cyskin_electronics,
    icub_electronics,
    ideal_electronics,
)
from skinfield.simulate.rig import At, LoadProfile, Scenario

HEAD = "skinfield_rig = 1\n"


@pytest.mark.parametrize("make", [icub_electronics, cyskin_electronics, ideal_electronics])
def test_presets_are_those_of_the_package(make: Callable[[], Electronics]) -> None:
    name = make.__name__.removesuffix("_electronics")
    text = f'{HEAD}[electronics]\npreset = "{name}"\n'
    assert scenario_from_toml(text) == Scenario(electronics=make())


@given(st.integers(-9999, 9999))
def test_numbers_are_those_of_the_text_to_the_last_digit(digits: int) -> None:
    for key, power in (("x_mm", "e-5"), ("x_kpa", "e1"), ("x_pf", "e-14"), ("x_s", "e-2")):
        assert si_from_value(key, digits / 100) == float(f"{digits}{power}")


def test_units_are_what_they_say() -> None:
    scenario = scenario_from_toml(
        HEAD + "[layer]\nthickness_mm = 3\nyoung_modulus_kpa = 40\n[load_cell]\nnoise_mn = 5\n"
        "[temperature]\nstart_c = 20\n"
        '[[places]]\nkind = "at"\npositions_mm = [[1, -2.5]]\nangle_deg = 90\n'
    )
    assert scenario.layer == Layer(3e-3, 40e3)
    assert scenario.load_cell.noise == 5e-3
    assert scenario.temperature.start == 293.15
    (at,) = scenario.places
    assert isinstance(at, At)
    assert at.positions == ((1e-3, -2.5e-3),)
    assert at.angle == pytest.approx(np.pi / 2)


def test_the_template_has_all_that_it_says_and_its_values_are_the_defaults() -> None:
    scenario = scenario_from_toml(template())
    assert [tool.name for tool in scenario.tools] == ["sphere6", "cylinder3"]
    usual = Scenario()
    for name in ("layer", "elastomer", "loads", "profile", "load_cell", "temperature", "solving",
                 "electronics", "seed", "repeats", "name", "cover"):  # fmt: skip
        assert getattr(scenario, name) == getattr(usual, name), name
    assert scenario.tools[:1] == usual.tools
    assert scenario.places[:1] == usual.places
    assert set(tomllib.loads(template())["profile"]) == set(
        map(key_of, LoadProfile.__dataclass_fields__)
    )
    assert set(PARTS) < {name.name for name in Electronics.__dataclass_fields__.values()}


MISTAKES = [
    ("[profile]\nhold = 3", r"press.toml:3: \[profile\]: 'hold' is not known.*hold_s"
     r".*did you mean hold_s"),
    ("[profile]\nhold_s = 'a'", r"press.toml:3: .*hold_s is 'a', expected a finite number"),
    ("[profile]\n\nhold_s = -1", r"press.toml:2: \[profile\]: hold is -1.0, expected a number"),
    ("[profile]\nsmooth = 1", "smooth is 1, expected true or false"),
    ("[layer]\npoisson_ratio = 0.7", "poisson_ratio is 0.7, expected a number from 0 to 0.5"),
    ("[[places]]\nkind = 'over'", r"\[places\[0\]\]: kind is 'over', expected one of over_taxel"),
    ("[[places]]\nkind = 'random'\n[[places]]\nkind = 'random'\nwithin = 3",
     r"press.toml:6: \[places\[1\]\]: 'within' is not known.*did you mean within_mm"),
    ("[[places]]\nkind = 'between_two'\npairs = [1, 2]", "pairs is .1, 2., expected a list"),
    ("[[places]]\nkind = 'at'", "positions_mm is missing, expected rows of x and y"),
    ("[places]\nkind = 'at'", r"expected tables: \[\[places\]\]"),
    ("[[indenter]]\nshape = 'sphere'\nradius = 3", "press.toml:4: .*did you mean radius_mm"),
    ("[[indenter]]\nshape = 'sphere'\nradius_mm = 3\nforce_n = 1", r"those of all .* in \[loads\]"),
    ("[elecronics]\n", "'elecronics' is not known.*did you mean electronics"),
    ("[electronics.noise]\nwhite = 3", r"\[electronics.noise\]: 'white' .*white_counts"),
    ("[electronics]\npreset = 'icube'", r"preset is 'icube', expected .*\(did you mean icub\?\)"),
    ("[electronics.board]\nkind = 'icub'\nno_load = 900", "no_load is 900, expected a whole"),
    ("[electronics.board]\nkind = 'linear'\ngain_counts = 9", "'gain_counts' is not known"),
    ("[patch]\nlayout = 'hexagon'", r"press.toml:3: \[patch\]: .*hexagon"),
    ("[patch]\nlayout = 'rectangular:rows=x'", r"\[patch\]: rows of rectangular is 'x'"),
    ("[[indenter]]\nshape = 'sphere'\nradius_mm = 3\nshear_x_n = 1", "shear_part in .loads"),
    ("[loads]\nforces_n = []", "expected one of the two"),
    ("[loads]\nforces_n = [1e400]", "expected a list of finite numbers"),
    ("[loads]\nforces_n = [nan]", "expected a list of finite numbers"),
    ("[loads]\nforces_n = 1", "expected a list of finite numbers"),
    ("[solving]\nrungs = 2", "rungs is 2, expected a whole number from 4"),
    ("seed = 1.5", "seed is 1.5, expected a whole number"),
    ("name = 'a/b'", "name is 'a/b', expected up to 40 letters"),
    ("layer = 3", r"layer is 3, expected a table: \[layer\]"),
    ("= 3", "press.toml is not TOML"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "said"), MISTAKES)
def test_mistakes_are_named_with_their_place(text: str, said: str) -> None:
    with pytest.raises(FileError, match=said):
        scenario_from_toml(HEAD + text, path="press.toml")


def test_other_files_are_told_apart(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="skinfield_rig is missing, expected 1"):
        scenario_from_toml("x = 1")
    with pytest.raises(FileError, match="cannot be read: No such file"):
        load_scenario(tmp_path / "none.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FileError, match="not text in UTF-8"):
        load_scenario(tmp_path / "bytes.toml")


VALUE = st.sampled_from([
    "1", "-1", "1e999", "nan", "inf", "true", "'x'", "[]", "[1]", "[[1, 2]]", "{}", "{a = 1}",
    "1979-05-27", "[nan]", "0x10", "9" * 30, "9" * 5000, "''", "'sphere'", "'../x'", "1e-999999",
])  # fmt: skip
KEY = st.sampled_from([
    "name", "seed", "layout", "thickness_mm", "hold_s", "kind", "taxels", "shape", "radius_mm",
    "file", "forces_n", "depths_mm", "rate_hz", "start_c", "preset", "rungs", "prony_terms",
    "positions_mm", "relaxed_fraction", "no_load", "count", "'a b'",
])  # fmt: skip
SECTION = st.sampled_from([
    "patch", "layer", "elastomer", "loads", "profile", "load_cell", "temperature", "solving",
    "electronics", "electronics.noise", "electronics.board", "electronics.delivery", "other",
])  # fmt: skip
LINE = st.one_of(
    st.builds("{} = {}".format, KEY, VALUE),
    SECTION.map("[{}]".format),
    st.sampled_from(["[[indenter]]", "[[places]]", "[[patch]]", "shape = 'sphere'"]),
)


@given(st.lists(LINE, max_size=8))
@settings(max_examples=300)
def test_any_mixture_of_keys_is_a_scenario_or_a_clear_error(lines: list[str]) -> None:
    _survives(HEAD + "\n".join(lines))


@given(st.integers(0, len(template())), st.integers(0, 40), st.text(max_size=6))
@settings(max_examples=150)
def test_a_damaged_file_is_a_scenario_or_a_clear_error(at: int, gone: int, put: str) -> None:
    _survives(template()[:at] + put + template()[at + gone :])


def _survives(text: str) -> None:
    try:
        scenario = scenario_from_toml(text, path="garbage.toml")
    except FileError:
        return
    assert isinstance(scenario, Scenario)


def test_a_layout_beside_the_file_is_found(tmp_path: Path) -> None:
    patch = sf.layouts.icub_hexagon().subset(np.arange(24))
    save_layout(patch, tmp_path / "mine.toml")
    (tmp_path / "s.toml").write_text(HEAD + "[patch]\nlayout = 'mine.toml'\n")
    scenario = load_scenario(tmp_path / "s.toml")
    assert scenario.patch.positions == pytest.approx(patch.positions)


def test_shapes_from_files_are_found_beside_a_scenario(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    trimesh.creation.icosphere(subdivisions=2, radius=4.0).export(tmp_path / "ball.stl")
    table = '[[indenter]]\nshape = "mesh"\nfile = "ball.stl"\nunit_mm = 1.5\ndown = [0, 0, -1]\n'
    (tmp_path / "s.toml").write_text(HEAD + table)
    (tool,) = load_scenario(tmp_path / "s.toml").tools
    assert tool.name == "mesh-1"
    assert tool.indenter.height(np.array([3e-3]), np.zeros(1)) == pytest.approx(0.77e-3, rel=0.1)
