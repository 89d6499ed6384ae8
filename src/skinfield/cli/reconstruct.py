"""`skinfield reconstruct`: recordings become contacts and fields."""

from pathlib import Path
from typing import Annotated, NoReturn

from skinfield.cli import options, report
from skinfield.errors import FileError, InputError
from skinfield.settings import Elastomer, ModelSettings

ENDING = ".skinfield"
OF_RESULTS = (  # options for results as well
    "output", "fields", "summary", "plot", "reading", "slice_", "workers", "scheduler",
    "store_fields", "force", "as_json",
)  # fmt: skip
OF_ONE = ("fields", "summary", "plot", "reading", "slice_")
OF_MANY = ("workers", "scheduler", "store_fields")


def reconstruct(
    *recording: str,
    layout: str | None = None,
    patch: options.PatchName = None,
    output: Annotated[tuple[str, ...], options.OUTPUT] = (),
    fields: str | None = None,
    summary: str | None = None,
    plot: str | None = None,
    reading: int | None = None,
    slice_: str | None = None,
    workers: options.Workers = None,
    scheduler: str | None = None,
    store_fields: bool = False,
    force: options.Force = False,
    as_json: options.Json = False,
    counts: options.Counts = options.CountSettings(),
    elastomer: options.OfElastomer = Elastomer(),
    model: options.Model = ModelSettings(),
) -> None:
    """Turn recordings of a skin into force, deformation and contacts.

    A RECORDING is a yarpdatadumper log or its folder, a CySkin text recording, a CSV or NPZ file of
    your own, or what 'skinfield record' wrote; or results that an earlier run left with -o
    run.skinfield.

    Counts become ΔC/C₀ through the board's convention and a gain, or a calibration file; without
    one the gain is a guess and forces are true up to one factor, which 'skinfield calibrate scale'
    finds. What was assumed, skipped or left out is said in notes.

    A recording may be longer than memory. -o run.skinfield stores its readings, its contacts and
    what reconstructs them, far less than the fields, which are computed when they are looked at: in
    Python with skinfield.open_results, here with --slice. Solvers that start from the reading
    before (nonnegative, contact) do so within runs of 64 readings and begin anew at each.

    Several recordings, or one by several processes, go into a folder: -o DIR gets results of each,
    made window by window by Dask's workers, here or on a cluster. What is complete stands in
    DIR/manifest.json: the same command goes on where a run was ended.

      skinfield reconstruct foot/data.log --skin right_foot.txt -o contacts.csv --plot foot.png
      skinfield reconstruct press.csv --skin hexagon72 --grid 40 --fields press.npz
      skinfield reconstruct touch.mcap -o contacts.csv
      skinfield reconstruct hours.csv --skin hexagon72 --grid 40 -o hours.skinfield
      skinfield reconstruct hours.skinfield --slice 100:200 --fields part.npz
      skinfield reconstruct mon.csv tue.csv wed.csv --skin hexagon72 --workers 8 -o week

    Parameters
    ----------
    recording : str
        Recordings, or a folder of results.
    layout : str, optional
        Layout file, or a generator by name. Default what a recording (.mcap) has enclosed, with
        its calibration and its settings of skin and elastomer.
    output : tuple of str
        Contacts of every reading: .csv or .parquet; or all results: .skinfield; again for more. Or
        a DIR, for results of several recordings.
    fields : str, optional
        Pressure and displacement: .npz.
    summary : str, optional
        Summary of the run: .json.
    plot : str, optional
        Figure of the reading with the highest load: .png, .pdf or .svg.
    reading : int, optional
        Draw and list this reading (from 0) instead.
    slice_ : str, optional
        FROM:TO: readings to work on, from 0, TO left out; .skinfield holds all.
    scheduler : str, optional
        Of a Dask cluster whose workers see the same files, such as tcp://10.0.0.1:8786.
    store_fields : bool
        Into a DIR, store the fields of every reading, too, as Zarr.
    """
    flags = options.flags_set(reconstruct, dict(locals()))
    from skinfield.cli.reconstruct_jobs import Plan
    from skinfield.cli.reconstruct_runs import Wanted, reconstruct_many, reconstruct_one

    folder = _folder_of(recording, output)
    if folder is None and (odd := [flag for name, flag in flags if name in OF_MANY]):
        _refuse(odd, "expected -o DIR, a name without an ending, into which workers write")
    if folder is not None and (odd := [flag for name, flag in flags if name in OF_ONE]):
        results = f"'skinfield reconstruct {folder}/NAME{ENDING}'"
        _refuse(odd, f"expected none beside -o {folder}; ask its folders of results, as {results}")
    if not recording:
        raise InputError("RECORDING is missing, expected one recording or more")
    are_results = any(map(_is_results, recording))
    if are_results and (folder is not None or len(recording) > 1):
        raise InputError(
            f"{ENDING} folders are results already, expected recordings for {folder}, or one "
            "folder of results"
        )
    if layout is None and recording[0].lower().endswith(options.LIVE):
        layout = recording[0]
    if layout is None and not are_results:
        raise InputError("--skin is missing, expected a layout file, or a generator by name")
    plan = None
    if layout is not None and not are_results:
        plan = Plan.of(layout, patch, counts, elastomer, model)
    if plan is not None and folder is not None:
        many = options.processes(workers), scheduler
        reconstruct_many(recording, folder, plan, many, store_fields, as_json)
        return
    for name in output:
        report.check_output("--output", name, force, ".csv", ".parquet", ENDING)
    report.check_output("--fields", fields, force)
    report.check_output("--summary", summary, force, ".json")
    report.check_picture("--plot", plot, force)
    if plan is None:
        odd = [flag for name, flag in flags if name not in OF_RESULTS]
        odd += [f"-o {Path(name).name}" for name in output if name.lower().endswith(ENDING)]
        if odd:
            _refuse(odd, "results were made with theirs; expected none, or the recording itself")
    wanted = Wanted(output, fields, summary, plot, reading, slice_)
    reconstruct_one(recording[0], plan, wanted, as_json)


def _refuse(flags: list[str], why: str) -> NoReturn:
    raise InputError(f"{', '.join(flags)} would have no effect: {why}")


def _folder_of(recordings: tuple[str, ...], outputs: tuple[str, ...]) -> Path | None:
    """Where results of many go: the output that has no ending."""
    folders = [name for name in outputs if not Path(name).suffix]
    if folders and len(outputs) > 1:
        raise InputError(
            f"-o names {', '.join(outputs)}, expected the folder {folders[0]} alone: it gets "
            "contacts and results of each recording"
        )
    if not folders and len(recordings) > 1:
        raise InputError(
            f"{len(recordings)} recordings, expected -o DIR, a name without an ending, which "
            "gets results of each; or one recording"
        )
    return Path(folders[0]) if folders else None


def _is_results(recording: str) -> bool:
    """Whether it is a folder of results; raises FileError of one of anything else."""
    path = Path(recording)
    if not path.is_dir() or (path / "data.log").exists():
        return False
    if not recording.rstrip("/").lower().endswith(ENDING):
        raise FileError(
            f"{recording} is a folder without data.log, expected a recording: a file, the folder "
            f"of a yarpdatadumper log, or results (NAME{ENDING})"
        )
    return True
