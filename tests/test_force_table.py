"""Force sensors' recordings as tables."""

from pathlib import Path

import pytest

from skinfield.errors import FileError
from skinfield.files import open_recording


@pytest.mark.parametrize("names", ["fx,fy,fz", "Fx,Fy,Fz", "fx,fy,fz,mx,my,mz"])
def test_a_table_of_forces_needs_no_taxels(tmp_path: Path, names: str) -> None:
    width = names.count(",") + 1
    path = tmp_path / "force.csv"
    rows = [f"{0.01 * row},{','.join(str(row + k) for k in range(width))}" for row in range(5)]
    path.write_text("\n".join([f"time_s,{names}", *rows]) + "\n")
    recording = open_recording(path)
    assert recording.unit == "N, N m"
    assert recording.counts[2].tolist() == [2.0 + k for k in range(width)]
    assert recording.stamp_ns[1] == pytest.approx(10_000_000)


def test_forces_and_taxels_do_not_mix(tmp_path: Path) -> None:
    path = tmp_path / "mixed.csv"
    path.write_text("time_s,fx,taxel_0\n0,1,2\n0.1,1,2\n")
    with pytest.raises(FileError, match="column 'fx' is not a time"):
        open_recording(path)
