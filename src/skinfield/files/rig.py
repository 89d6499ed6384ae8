"""Files of a virtual rig, which the rest of the program takes for a real one's."""

from pathlib import Path

from skinfield.files.layouts.load import save_layout
from skinfield.files.pending import write_bytes, write_npz
from skinfield.files.recordings.archive import save_recording, seconds
from skinfield.signal import save_calibration
from skinfield.simulate.rig import LoadSeries, RigRun

RECORDING, LOAD_CELL, TRUTH = "recording.npz", "load_cell.csv", "truth.npz"
LAYOUT, CALIBRATION = "layout.toml", "calibration.toml"


def save_rig_run(run: RigRun, folder: str | Path) -> None:
    """Write recording, load cell, truth, layout and true calibration into a folder that is there.

    Raises
    ------
    FileError
        If a file cannot be written.
    """
    folder = Path(folder)
    save_recording(run.recording, folder / RECORDING)
    save_load_cell(run.load_cell, folder / LOAD_CELL)
    write_npz(folder / TRUTH, run.truth.arrays())
    save_layout(run.scenario.patch, folder / LAYOUT)
    save_calibration(run.skin.calibration, folder / CALIBRATION)


def save_load_cell(series: LoadSeries, path: str | Path) -> None:
    """Write a load cell's series as a force sensor's CSV: ``time_s,fx,fy,fz``, pushed to -z."""
    full = int(series.saturated.sum())
    lines = [
        f"# {full} of {len(series.force)} samples are at the end of the cell's range\n",
        "time_s,fx,fy,fz\n",
    ]
    for stamp, force in zip(series.stamp_ns.tolist(), series.force.tolist(), strict=True):
        lines.append(f"{seconds(stamp)},0.0,0.0,{0.0 - force!r}\n")
    write_bytes(path, "".join(lines).encode())
