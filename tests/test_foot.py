"""A real foot beside its force sensor: the numbers of the docs, and what is said without data."""

from pathlib import Path

import pytest

from skinfield.lab.report import SMOKE, Missing, Section, Settings
from skinfield.lab.sections.foot import foot, foot_forces


def test_without_data_it_says_what_is_not_there(tmp_path: Path) -> None:
    nothing = foot(Settings(size=SMOKE))
    assert isinstance(nothing, Missing)
    assert "no folder of recordings was given" in nothing.reason
    absent = foot(Settings(size=SMOKE, data=str(tmp_path)))
    assert isinstance(absent, Missing)
    assert "dumperTippingSetup07" in absent.reason
    assert str(tmp_path) in absent.reason


def test_the_foot_stands_and_tips(shared_data: Path) -> None:
    """The command line's fit of the same recording gives 44.2 kPa; docs/limits.md has the rest."""
    found = foot_forces(shared_data)
    assert found.modulus == pytest.approx(44.2e3, rel=0.01)
    standing, edge = found.parts["standing"], found.parts["on its edge"]
    assert standing["error, mean (N)"] == pytest.approx(0.0, abs=0.5)
    assert 2.0 < standing["error, rms (N)"] < 3.5
    assert 2.0 < found.held_out < 3.5
    assert 20 < found.parts["tipping"]["error, rms (N)"] < 30
    assert edge["sensor (N)"] == pytest.approx(117, abs=2)
    assert edge["skin (N)"] == pytest.approx(17, abs=2)  # the foot rests beyond its taxels


def test_the_foot_is_a_section(shared_data: Path) -> None:
    section = foot(Settings(size=SMOKE, data=str(shared_data)))
    assert isinstance(section, Section)
    assert section.pictures[0].png.startswith(b"\x89PNG")
    assert "modulus of 44.2 kPa" in section.sentences[0]
    assert len(section.tables[0].rows) == 4
