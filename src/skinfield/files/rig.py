"""Files of a virtual rig, which the rest of the program takes for a real one's."""

from pathlib import Path

from skinfield.files.archive_writer import save_recording, seconds
from skinfield.files.layouts.load import save_layout
from skinfield.files.pending import write_bytes, write_npz
from skinfield.signal import save_calibration
from skinfield.simulate.rig import LoadSeries, RigRun, Truth

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
    save_truth(run.truth, folder / TRUTH)
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


def save_truth(truth: Truth, path: str | Path) -> None:
    """Write a rig's truth as NPZ; `Truth` lists the keys."""
    write_npz(path, truth.arrays())
