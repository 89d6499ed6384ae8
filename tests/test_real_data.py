"""What recorded data say, beside the docs' numbers, and what is said where they are absent."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skinfield.errors import FileError, InputError
from skinfield.experiments.recorded.fabric import (
    RUNS,
    fabric_runs,
    falling_curve,
    judged_on_the_rest,
    load_run,
)
from skinfield.experiments.recorded.finding import AbsentData, Finding
from skinfield.experiments.recorded.foot import foot_forces
from skinfield.experiments.recorded.real_data import FINDINGS, findings, section_of, sections
from skinfield.experiments.recorded.tables import HAYES, agreements, read_table
from skinfield.experiments.recorded.tension import FILE, tension, theory_leaves


def test_without_data_each_says_what_is_not_there(tmp_path: Path) -> None:
    for found in findings(tmp_path):
        assert isinstance(found, AbsentData)
        assert str(tmp_path) in str(found)
    made = sections(tmp_path)
    assert [section.name for section in made] == [f"real-{name}" for name, _ in FINDINGS]
    assert "dumperTippingSetup07" in made[0].sentences[0]
    assert "tables/hayes_flat_punch_kappa.csv is not in" in made[1].sentences[0]


def test_the_foot_stands_and_tips(shared_data: Path) -> None:
    """The command line's fit of the same recording gives 44.2 kPa; docs/limits.md has the rest."""
    found = foot_forces(shared_data)
    assert found.modulus == pytest.approx(44.2e3, rel=0.01)
    standing, edge = found.parts["standing"], found.parts["on its edge"]
    assert standing["bias"] == pytest.approx(0.0, abs=0.5)
    assert 2.0 < standing["rms"] < 3.5
    assert 2.0 < found.held_out < 3.5
    assert 20 < found.parts["tipping"]["rms"] < 30
    assert edge["sensor"] == pytest.approx(117, abs=2)
    assert edge["skin"] == pytest.approx(17, abs=2)  # the foot rests beyond its taxels


def test_tables_are_met(shared_data: Path) -> None:
    found = agreements(shared_data)
    for each in found:
        if each.column == HAYES:
            assert 0.02 < each.largest < 0.035  # numbers of 1972
        elif each.by == "exact":
            assert each.largest < 5e-6, each
        else:
            assert each.largest < 1e-3, each
    assert len({each.column for each in found if each.by == "exact"}) == 6


def test_silicone_is_neo_hookean_at_first(shared_data: Path) -> None:
    found = tension(shared_data)
    assert found.chosen.modulus == pytest.approx(50.4e3, rel=0.01)
    assert np.abs(found.off("neo-hooke", np.linspace(0.15, 1.0, 30))).max() < 0.06
    assert found.off("hooke", np.array([0.5]))[0] == pytest.approx(0.42, abs=0.03)
    assert found.leaves("hooke", 0.05) < found.leaves("hooke", 0.10) < 0.2
    assert 200 < found.noise < 400


def test_fabric_leaves_a_fifth_of_the_force_open(shared_data: Path) -> None:
    for run in fabric_runs(shared_data).values():
        assert 4.0 < run.rms() < 8.0
        assert 0.1 < run.relative < 0.3
        assert run.rms(touched=False) < run.rms()


def test_a_finding_becomes_a_section() -> None:
    finding = Finding("x", "a thing", "someone", ("It holds.",), ({"force (N)": 1.0},))
    section = section_of(finding)
    assert section.name == "real-x"
    assert section.tables[0].rows == ((1.0,),)
    assert section.sentences == ("It holds.", "Data: someone.")
    with pytest.raises(InputError, match=r"row 1 of 'x' has columns \['b'\], expected \['a'\]"):
        Finding("x", "", "", (), ({"a": 1}, {"b": 1}))


def pulled(folder: Path, modulus: float) -> None:
    """A test of a perfect neo-Hookean rubber."""
    strain = np.linspace(0.01, 3.5, 400)
    stress = modulus / 3e6 * ((1 + strain) - (1 + strain) ** -2)
    rows = [f"{e:.9g};{s:.9g}" for e, s in zip(strain, stress, strict=True)]
    path = folder.joinpath(*FILE)
    path.parent.mkdir(parents=True)
    path.write_text("Engineering Strain;Engineering Stress (MPa)\n" + "\n".join(rows))


def test_a_perfect_rubber_is_told_from_hooke(tmp_path: Path) -> None:
    pulled(tmp_path, 70e3)
    found = tension(tmp_path)
    assert found.chosen.modulus == pytest.approx(70e3, rel=1e-6)
    assert np.abs(found.off("neo-hooke", np.linspace(0.05, 3, 50))).max() < 1e-4
    assert np.isnan(found.leaves("neo-hooke", 0.05))
    for share in (0.05, 0.10):
        assert found.leaves("hooke", share) == pytest.approx(theory_leaves(share), abs=0.005)
    assert theory_leaves(0.05) == pytest.approx(0.05, abs=0.003)  # 1 + strain + ... at first


def test_the_falling_curve_is_judged_on_what_it_has_not_seen(tmp_path: Path) -> None:
    """Noise is averaged away, a count's step remains; a taxel that drifts is off by its drift."""
    random = np.random.default_rng(0)
    force = random.uniform(0, 50, 2000)
    counts = np.round(1000 - 15 * force)
    noisy = judged_on_the_rest(counts, force + random.normal(size=2000)) - force
    assert 0.1 < noisy.std() < 0.5  # the curve has averaged the noise away
    level, curve = falling_curve(counts, force)
    assert np.all(np.diff(curve) <= 0)
    assert np.abs(np.interp(counts, level, curve) - force).max() < 1 / 15
    late = np.arange(2000) >= 1600
    drifting = judged_on_the_rest(counts, force + 10 * late) - (force + 10 * late)
    assert np.sqrt(np.mean(drifting[late] ** 2)) == pytest.approx(10, abs=0.5)


@settings(max_examples=60)
@given(st.one_of(st.binary(max_size=200), st.text(max_size=200).map(str.encode)))
def test_garbage_is_refused(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    path = tmp_path_factory.mktemp("garbage") / next(iter(RUNS.values()))
    path.write_bytes(content)
    with pytest.raises(FileError):
        load_run(path)
    with pytest.raises(FileError):
        read_table(path)


def test_the_line_is_named(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("# force_N,adc\n1.0,500\n2.0\n")
    with pytest.raises(FileError, match=r"run.csv:3 is '2.0', expected two numbers"):
        load_run(path)
    path.write_text("a,b\n1,2\n3,nan\n")
    with pytest.raises(FileError, match=r"run.csv:3 has a number that is not finite"):
        read_table(path)
