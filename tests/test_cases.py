"""Cases: what is written is read back, whatever is broken is said, presses can be moved."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from skinfield.elastic import BondedLayer, HalfSpace, Layer
from skinfield.errors import FileError, InputError
from skinfield.lab.case_files import FORMAT, case_paths, load_case, save_case
from skinfield.lab.case_sets import KINDS, CaseKind, standard_cases
from skinfield.lab.cases import Case, TrueContact, Truth
from skinfield.simulate import Cylinder, Press, Sphere, press
from skinfield.skin import Patch
from skinfield.skin.generators import hexagon72

LAYER = Layer(2e-3, 100e3, 0.5)
BODIES = (
    Sphere(radius=6e-3, force=1.0, position=(-4e-3, 0.0)),
    Cylinder(radius=2e-3, force=0.5, position=(5e-3, 1e-3)),
)
MOVE = (1.3e-3, -2.1e-3, 0.4)  # m, m, rad


@pytest.fixture(scope="module")
def two() -> Press:
    return press(LAYER, list(BODIES), extent=24e-3, cell=0.5e-3)


@pytest.fixture(scope="module")
def case(two: Press) -> Case:
    return Case.from_press("two", two, hexagon72(), "stress", (2e-3, -3e-3, 0.7), 300.0)


def test_a_case_survives_its_file(case: Case, tmp_path: Path) -> None:
    noisy = case.with_noise(seed=3, draws=5)
    path = save_case(noisy, tmp_path)
    assert path.name == "two.npz"
    assert case_paths(tmp_path) == [path]
    back = load_case(path)
    assert (back.name, back.quantity, back.noisy) == ("two", "stress", True)
    assert back.layer == LAYER
    assert back.mechanics == BondedLayer()
    assert back.readings.shape == (5, 72)
    np.testing.assert_array_equal(back.readings, noisy.readings)
    np.testing.assert_array_equal(back.noise_std, np.full(72, 300.0))
    for name in ("positions", "normals", "module", "uid", "channel", "link_from_patch"):
        np.testing.assert_array_equal(getattr(back.patch, name), getattr(case.patch, name))
    assert back.patch.pad_diameter == case.patch.pad_diameter
    for name in ("plane", "pressure", "displacement"):
        np.testing.assert_array_equal(getattr(back.truth, name), getattr(case.truth, name))
    assert back.truth.contacts == case.truth.contacts
    assert back.truth.source == "skinfield.simulate.pressing.press"


def test_truth_of_a_press(two: Press, case: Case) -> None:
    ball, flat = case.truth.contacts
    assert (ball.kind, flat.kind) == ("ball", "flat cylinder")
    assert ball.force == pytest.approx(1.0, rel=1e-5)
    assert case.truth.force == pytest.approx(1.5, rel=1e-5)
    assert case.truth.contact_area == pytest.approx(two.contact_area, rel=1e-12)
    assert flat.area == pytest.approx(np.pi * 2e-3**2, rel=0.05)
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    for body, contact in zip(BODIES, case.truth.contacts, strict=True):
        expected = turn @ body.position + [2e-3, -3e-3]
        # neighbours lean on each other: the centre of pressure shifts a little
        assert np.hypot(*(expected - contact.position)) < 0.15e-3


@pytest.fixture(scope="module")
def there() -> Press:
    x, y, angle = MOVE
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    bodies = [
        replace(body, position=tuple(turn @ body.position + [x, y]), rotation=angle)
        for body in BODIES
    ]
    return press(LAYER, bodies, extent=30e-3, cell=0.5e-3)


@pytest.mark.parametrize(  # the electrostatics are sampled on a mesh of 0.2 mm
    ("quantity", "close"), [("stress", 1e-3), ("gap", 1e-3), ("capacitance", 1.5e-2)]
)
def test_moved_press_is_a_press_that_was_solved_there(
    two: Press, there: Press, quantity: str, close: float
) -> None:
    moved = Case.from_press("moved", two, hexagon72(), quantity, MOVE)
    again = Case.from_press("there", there, hexagon72(), quantity)
    scale = np.abs(again.readings).max()
    np.testing.assert_allclose(moved.readings, again.readings, atol=close * scale)
    for one, other in zip(moved.truth.contacts, again.truth.contacts, strict=True):
        assert one.position == pytest.approx(other.position, abs=0.02e-3)
    place = np.argmin(np.linalg.norm(again.truth.plane - MOVE[:2], axis=1))
    near = np.argmin(np.linalg.norm(moved.truth.plane - again.truth.plane[place], axis=1))
    np.testing.assert_allclose(
        moved.truth.displacement[near], again.truth.displacement[place], atol=0.08e-3
    )


def test_noise_is_that_of_the_seed_and_of_its_size(case: Case) -> None:
    noisy = case.with_noise(seed=1, draws=2000)
    np.testing.assert_array_equal(noisy.draws, case.with_noise(seed=1, draws=2000).draws)
    assert (noisy.readings - case.readings).std() == pytest.approx(300.0, rel=0.01)
    assert np.abs(noisy.readings.mean(axis=0) - case.readings).max() < 300.0 / 2000**0.5 * 5
    with pytest.raises(InputError, match="holds noise already"):
        noisy.with_noise(seed=2)


def test_measured_contacts_alone_are_a_case(tmp_path: Path) -> None:
    path = tmp_path / "rig.npz"
    arrays = {
        "skinfield_case": 1, "quantity": "capacitance", "readings": np.zeros(3), "noisy": True,
        "noise_std": 0.002, "patch/pad_diameter_m": 4e-3,
        "patch/positions_m": np.array([[0.0, 0], [5e-3, 0], [0, 5e-3]]),
        "layer/thickness_m": 2e-3, "layer/young_modulus_Pa": 1e5, "layer/poisson_ratio": 0.5,
        "truth/contact_position_m": np.array([[1e-3, 2e-3]]),
        "truth/contact_force_N": np.array([1.2]),
    }  # fmt: skip
    np.savez(path, **arrays)
    case = load_case(path)
    assert case.name == "rig"
    assert case.truth.contacts[0].force == 1.2
    assert np.isnan(case.truth.contact_area)
    assert len(case.truth.plane) == 0


def saved(case: Case, folder: Path, **changes: object) -> Path:
    path = save_case(case, folder)
    with np.load(path) as archive:
        arrays = {key: archive[key] for key in archive.files}
    for key, value in changes.items():
        key = key.replace("__", "/")
        arrays[key] = value
    np.savez(path, **{key: value for key, value in arrays.items() if value is not None})
    return path


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"readings": np.zeros(71)}, r"readings has shape \(71,\), expected \(72,\)"),
        ({"readings": None}, "no array 'readings'"),
        ({"readings": np.array(["a"] * 72)}, "readings is of type <U1, expected numbers"),
        ({"quantity": "volts"}, "quantity is 'volts', expected one of capacitance, gap, stress"),
        ({"noise_std": 0.0}, "noise_std is 0.0, expected a finite number above 0"),
        ({"noisy": 1}, "noisy is of type int64, expected true or false"),
        ({"skinfield_case": 2}, "skinfield_case is 2, expected 1"),
        ({"layer__thickness_m": 2.0}, "give it in metres"),
        ({"layer__poisson_ratio": np.zeros(2)}, r"layer/poisson_ratio has shape \(2,\)"),
        ({"truth__pressure_Pa": np.zeros(3)}, r"truth/pressure_Pa has shape \(3,\)"),
        ({"truth__contact_force_N": np.array([-1.0, 1.0])}, "force is -1.0"),
        ({"truth__contact_kind": np.array(["ball"])}, r"truth/contact_kind has shape \(1,\)"),
        ({"truth__presure_Pa": np.zeros(3)}, "the key 'truth/presure_Pa' is not known"),
        ({"patch__uid": np.zeros(72)}, "patch/uid is of type float64, expected whole numbers"),
        ({"patch__pad_diameter_m": 4.0}, "pad_diameter is 4.0 m"),
    ],
)
def test_broken_files_say_what_is_wrong(
    case: Case, tmp_path: Path, changes: dict[str, object], words: str
) -> None:
    path = saved(case, tmp_path, **changes)
    with pytest.raises(FileError, match=words) as caught:
        load_case(path)
    assert str(path) in str(caught.value)


def test_no_code_is_read_from_a_file(case: Case, tmp_path: Path) -> None:
    path = saved(case, tmp_path, name=np.array([{"a": 1}], dtype=object))
    with pytest.raises(FileError, match="no case"):
        load_case(path)


def survives(path: Path) -> bool:
    """Whether a file is a case, or its FileError begins with its path."""
    try:
        load_case(path)
    except FileError as error:
        return str(error).startswith(str(path))
    return True


@settings(max_examples=60, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_spoilt_bytes_give_an_error_or_the_case(
    case: Case, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    path = save_case(case, tmp_path_factory.mktemp("spoilt"))
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 8))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(bytes(content[: data.draw(st.integers(0, len(content)))]))
    assert survives(path)


ANY_ARRAY = st.one_of(
    hnp.arrays(
        st.sampled_from([np.float64, np.int64, np.bool_, np.dtype("U3"), np.complex128]),
        hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4),
    ),
    st.sampled_from([np.array(np.nan), np.array(-1), np.array(2**62), np.full(72, np.inf)]),
)


@settings(max_examples=80, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_any_array_under_any_key_gives_an_error_or_a_case(
    case: Case, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    folder = tmp_path_factory.mktemp("any")
    node = {"plane": np.zeros((1, 2)), "pressure": [1.0], "displacement": np.zeros((1, 3))}
    small = replace(case, truth=replace(case.truth, **node))
    chosen = data.draw(st.lists(st.sampled_from([*FORMAT]), min_size=1, max_size=2))
    changes = {key: data.draw(st.none() | ANY_ARRAY) for key in chosen}
    assert survives(saved(small, folder, **changes))


def test_folders(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="expected at least one case"):
        case_paths(tmp_path)
    with pytest.raises(FileError, match="expected a folder of cases"):
        case_paths(tmp_path / "missing")


def test_a_case_is_checked(case: Case) -> None:
    for changes, words in (
        ({"mechanics": HalfSpace()}, "another model is what a solver assumes"),
        ({"name": "a/b"}, "name is 'a/b'"),
        ({"readings": np.full(72, np.inf)}, "infinity"),
    ):
        with pytest.raises(InputError, match=words):
            replace(case, **changes)
    with pytest.raises(InputError, match=r"position\[0\] is nan"):
        TrueContact((float("nan"), 0.0), 1.0)
    with pytest.raises(InputError, match="displacement has shape"):
        Truth(cell=1e-3, plane=[[0, 0]], pressure=[1.0], displacement=[[0, 0]], contacts=())


def test_standard_cases_are_those_of_the_seed() -> None:
    patch = Patch(np.array([[0.0, 0], [5e-3, 0], [0, 5e-3], [5e-3, 5e-3]]))
    first, second = (list(standard_cases(patch, 2, seed=5, quantity="stress")) for _ in range(2))
    for one, other in zip(first, second, strict=True):
        np.testing.assert_array_equal(one.readings, other.readings)
        assert one.truth.contacts == other.truth.contacts
    [other] = standard_cases(patch, 1, seed=6, quantity="stress")
    assert other.truth.contacts[0].position != first[0].truth.contacts[0].position
    assert len({kind.name for kind in KINDS}) == len(KINDS) == 22


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_every_standard_kind_can_be_pressed(kind: CaseKind) -> None:
    solved = press(kind.layer, list(kind.bodies), extent=28e-3, cell=1e-3)
    assert solved.residual < 1e-4
    assert solved.approach.max() < kind.layer.thickness
