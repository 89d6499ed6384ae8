"""Results out: what is written comes back, whole or not at all."""

import csv
import json
import resource
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skinfield as sf
from skinfield import files as sinks
from skinfield.errors import FileError, InputError, SkinfieldError
from skinfield.estimate import Contact, Estimate
from skinfield.estimate.contact_table import COLUMNS
from skinfield.skin.reading import Recording

PATCH = sf.Patch(np.random.default_rng(0).uniform(-0.02, 0.02, (12, 2)), name="palm")
GRID = sf.Grid.square(PATCH, nodes=4)
START = 1_424_362_797_536_033_000
CONTACTS = (0, 2, 1, 0, 3)  # of each reading


def contact(rng: np.random.Generator) -> Contact:
    return Contact(
        position=rng.normal(size=3) * 1e-2,
        force=rng.normal(size=3),
        moment=rng.normal(size=3),
        normal=np.array([0.0, 0.0, 1.0]),
        area=float(rng.uniform(1e-6, 1e-4)),
        peak_pressure=float(rng.uniform(1e3, 1e5)),
        covariance=np.diag([1e-8, 1e-8, 1e-4]),
        area_std=1e-6,
        radius=3e-3,
        shape="other",
        outline=np.zeros((5, 3)),
        axes=np.array([3e-3, 1e-3]),
        angle=0.5,
        cells=np.arange(3),
    )


def estimates(readings: int = len(CONTACTS), first: int = 0) -> Estimate:
    """Of readings, without the `first` of them."""
    rng = np.random.default_rng(1)
    nodes = len(GRID)
    contacts = [tuple(contact(rng) for _ in range(CONTACTS[k % 5])) for k in range(readings)]
    return Estimate(
        grid=GRID,
        pressure=rng.normal(size=(readings, nodes))[first:] * 1e4,
        traction=rng.normal(size=(readings, nodes, 3))[first:],
        displacement=rng.normal(size=(readings, nodes, 3))[first:] * 1e-4,
        pressure_std=np.full((readings - first, nodes), 50.0),
        contacts=tuple(contacts[first:]),
        residual=np.zeros((readings - first, 12)),
        valid=np.arange(12) > np.arange(first, readings)[:, None],
        readings=np.zeros((readings - first, 12)),
        readings_std=np.ones((readings - first, 12)),
        stamp_ns=START + np.arange(first, readings) * 20_000_000,
    )


def table(path: Path) -> list[dict[str, Any]]:
    """Rows of either kind of file, None for what is not there."""
    if path.suffix == ".parquet":
        parquet = pytest.importorskip("pyarrow.parquet")
        return parquet.read_table(path).to_pylist()
    with path.open(newline="") as file:
        return [
            {key: (text if key in ("shape", "scale") else float(text)) if text else None
             for key, text in row.items()}
            for row in csv.DictReader(file)
        ]  # fmt: skip


WRITERS = {  # by the ending of the file: to write it at once, and piece by piece
    ".csv": (sinks.write_contacts, sinks.open_contacts),
    ".parquet": (sinks.write_contacts, sinks.open_contacts),
    ".npz": (sinks.write_fields, sinks.open_fields),
}


@pytest.fixture(params=[".csv", ".parquet"])
def suffix(request: pytest.FixtureRequest) -> str:
    if request.param == ".parquet":
        pytest.importorskip("pyarrow")
    return request.param


EVERY = pytest.mark.parametrize("suffix", WRITERS, indirect=True)


# ---- contacts


def test_contacts_come_back_row_by_row(tmp_path: Path, suffix: str) -> None:
    batch, path = estimates(), tmp_path / f"c{suffix}"
    sinks.write_contacts(path, batch)
    rows = table(path)
    if suffix == ".csv":  # to the last digit
        stamps = {line.split(",")[1] for line in path.read_text().splitlines()[1:]}
        assert stamps == {str(batch.stamp_ns[k]) for k in (1, 2, 4)}
    assert list(rows[0]) == list(COLUMNS)
    assert [row["reading"] for row in rows] == [1, 1, 2, 4, 4, 4]
    assert [row["contact"] for row in rows] == [0, 1, 0, 0, 1, 2]
    assert [row["time_s"] for row in rows[::2]] == pytest.approx([0.02, 0.04, 0.08])
    for row in rows:
        reading, number = int(row["reading"]), int(row["contact"])
        one = batch[reading]
        assert row["total_force_N"] == pytest.approx(one.normal_force, rel=1e-8)
        assert row["valid_taxels"] == 11 - reading
        made = one.contacts[number]
        assert [row[k] for k in ("x_m", "y_m", "z_m")] == pytest.approx(made.position.tolist())
        assert [row[k] for k in ("fx_N", "fy_N", "fz_N")] == pytest.approx(made.force.tolist())
        assert row["force_N"] == pytest.approx(-made.force[2])
        assert row["area_m2"] == pytest.approx(made.area)
        assert row["place_std_m"] == pytest.approx(np.sqrt(2e-8))
        assert (row["shape"], row["radius_m"]) == ("other", 3e-3)
        assert row["peak_pressure_Pa"] == pytest.approx(made.peak_pressure)
        assert (row["axis_major_m"], row["axis_minor_m"], row["angle_rad"]) == (3e-3, 1e-3, 0.5)


def test_one_by_one_in_batches_and_in_chunks_are_the_same(tmp_path: Path, suffix: str) -> None:
    batch = estimates(23)
    sinks.write_contacts(tmp_path / f"all{suffix}", batch)
    sinks.write_contacts(tmp_path / f"each{suffix}", iter(batch))
    with sinks.open_contacts(tmp_path / f"mixed{suffix}") as writer:
        writer.write(batch[0])
        writer.write(estimates(23, 1))
    whole = table(tmp_path / f"all{suffix}")
    assert len(whole) == sum(map(len, batch.contacts))
    assert table(tmp_path / f"each{suffix}") == whole
    assert table(tmp_path / f"mixed{suffix}") == whole


def test_no_estimate_makes_no_row_and_what_is_not_finite_is_left_empty(
    tmp_path: Path, suffix: str
) -> None:
    path, batch = tmp_path / f"c{suffix}", estimates()
    sinks.write_contacts(path, [])
    assert table(path) == []
    if suffix == ".csv":
        assert path.read_text() == ",".join(COLUMNS) + "\n"
    unknown = {"covariance": np.full((3, 3), np.nan), "axes": np.array([1e-3, np.nan])}
    lone = replace(batch.contacts[1][0], **unknown)
    sinks.write_contacts(path, replace(batch[1], contacts=(lone,)))
    (row,) = table(path)
    assert (row["force_std_N"], row["axis_minor_m"], row["axis_major_m"]) == (None, None, 1e-3)


# ---- fields


def test_fields_come_back(tmp_path: Path) -> None:
    batch, path = estimates(23), tmp_path / "f.npz"
    with sinks.open_fields(path) as writer:
        writer.write(batch[0])
        for one in list(batch)[1:6]:
            writer.write(one)
        writer.write(estimates(23, 6))
    with np.load(path) as archive:
        got = dict(archive)
    np.testing.assert_array_equal(got["stamp_ns"], batch.stamp_ns)
    np.testing.assert_array_equal(got["pressure"], batch.pressure.reshape(23, 4, 4).astype("f4"))
    assert got["displacement"].dtype == np.float32
    np.testing.assert_allclose(
        got["displacement"].reshape(23, 16, 3), batch.displacement, rtol=1e-6
    )
    np.testing.assert_array_equal(got["position"].reshape(16, 3), GRID.positions)
    assert (got["pressure_std"] == 50).all()
    said = json.loads(str(got["attributes"]))
    assert (said["units"]["displacement"], said["patch"]) == ("m", "palm")


def test_fields_of_another_grid_or_of_nothing_are_refused(tmp_path: Path) -> None:
    path, batch = tmp_path / "f.npz", estimates()
    other = replace(batch, grid=sf.Grid(PATCH, (4, 4), 2e-3))
    with pytest.raises(InputError, match="one file holds one grid"):
        sinks.write_fields(path, [batch, other])
    with pytest.raises(InputError, match="no estimate was written"):
        sinks.write_fields(path, [])
    assert list(tmp_path.iterdir()) == []


# ---- whole or not at all


def failing() -> Iterator[Estimate]:
    yield estimates(60)
    raise RuntimeError("the solver failed")


@EVERY
def test_a_file_is_whole_or_not_there(tmp_path: Path, suffix: str) -> None:
    write, make = WRITERS[suffix]
    path = tmp_path / f"x{suffix}"
    writer = make(path)
    writer.write(estimates())
    assert not path.exists()
    writer.close()
    writer.close()  # twice does no harm
    before = path.read_bytes()
    with pytest.raises(RuntimeError, match="the solver failed"):
        write(path, failing())
    assert path.read_bytes() == before
    write(path, estimates(7))  # and is replaced by a whole one
    assert path.read_bytes() != before
    assert list(tmp_path.iterdir()) == [path]


@EVERY
def test_a_full_disk_is_said_and_leaves_nothing(tmp_path: Path, suffix: str) -> None:
    write, _ = WRITERS[suffix]
    batch = estimates(400)
    write(tmp_path / f"warm{suffix}", batch)  # what is imported writes no file below
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (3000, hard))
    try:
        with pytest.raises(FileError, match=rf"x{suffix} cannot be written: File too large"):
            write(tmp_path / f"x{suffix}", batch)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert [file.name for file in tmp_path.iterdir()] == [f"warm{suffix}"]


@EVERY
def test_places_that_cannot_be_written_are_named_at_once(tmp_path: Path, suffix: str) -> None:
    _, make = WRITERS[suffix]
    (tmp_path / "file").touch()
    (tmp_path / f"folder{suffix}").mkdir()
    for place, why in (
        (tmp_path / "none" / f"x{suffix}", "is no folder"),
        (tmp_path / "file" / f"x{suffix}", "is no folder|Not a directory"),
        (tmp_path / f"folder{suffix}", "neither results nor a bag"),
        (f"a\0{suffix}", "null byte"),
    ):
        with pytest.raises(FileError, match=why):
            make(place)


def test_a_device_is_not_replaced_and_the_file_behind_a_link_is_written(tmp_path: Path) -> None:
    device, link, real = (tmp_path / f"{name}.csv" for name in ("device", "link", "real"))
    device.symlink_to("/dev/null")
    with pytest.raises(FileError, match="cannot be replaced"):
        sinks.open_contacts(device)
    real.touch()
    link.symlink_to(real)
    sinks.write_contacts(link, estimates())
    assert device.is_symlink()
    assert link.is_symlink()
    assert len(table(real)) == 6


def test_other_extensions_and_missing_packages_are_refused(tmp_path: Path, monkeypatch) -> None:
    recording = Recording(np.arange(2), np.ones((2, 3)))
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    for name, make, why in (
        ("x.xlsx", sinks.open_contacts, r"expected a name that ends in \.\w+ or \.\w+"),
        ("x.txt", lambda path: sinks.save_recording(recording, path), r"ends in \.\w+ or \.\w+"),
        ("x.zarr", sinks.open_fields, r"expected a name that ends in \.npz"),
        ("x.csv", lambda path: sinks.save_recording(replace(recording, unit="V"), path), "is 'V'"),
        ("x.parquet", sinks.open_contacts, r"pip install 'skinfield\[parquet\]'"),
    ):
        with pytest.raises(SkinfieldError, match=why):
            make(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


# ---- summary


def test_summary_is_strict_json(tmp_path: Path) -> None:
    sinks.write_summary(
        tmp_path / "s.json",
        {
            "recording": tmp_path / "data.log",
            "readings": np.int64(3),
            "force_N": np.array([1.5, np.nan]),
            "good": np.bool_(True),
            "nested": {"rate": float("inf"), "names": ("a", None)},
        },
    )
    assert json.loads((tmp_path / "s.json").read_text(), parse_constant=pytest.fail) == {
        "recording": str(tmp_path / "data.log"),
        "readings": 3,
        "force_N": [1.5, None],
        "good": True,
        "nested": {"rate": None, "names": ["a", None]},
    }
    with pytest.raises(InputError, match=r"summary\['a'\]\[1\] is <object"):
        sinks.write_summary(tmp_path / "t.json", {"a": [1, object()]})
    assert not (tmp_path / "t.json").exists()
