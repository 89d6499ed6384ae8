"""`skinfield reconstruct`: recordings become contacts and fields."""

from pathlib import Path
from typing import Annotated

from skinfield.cli.options import (
    LIVE,
    OUTPUT,
    Counts,
    CountSettings,
    Force,
    Json,
    Model,
    OfElastomer,
    flags_set,
    processes,
)
from skinfield.cli.report import check_output, check_picture
from skinfield.errors import InputError
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
    patch: str | None = None,
    output: Annotated[tuple[str, ...], OUTPUT] = (),
    fields: str | None = None,
    summary: str | None = None,
    plot: str | None = None,
    reading: int | None = None,
    slice_: str | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    store_fields: bool = False,
    force: Force = False,
    as_json: Json = False,
    counts: Counts = CountSettings(),
    elastomer: OfElastomer = Elastomer(),
    model: Model = ModelSettings(),
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
    patch : str, optional
        Name or number of the patch of a layout with several.
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
    workers : int, optional
        Processes that work into a DIR. Default as many as there are cores.
    scheduler : str, optional
        Of a Dask cluster whose workers see the same files, such as tcp://10.0.0.1:8786.
    store_fields : bool
        Into a DIR, store the fields of every reading, too, as Zarr.
    as_json : bool
        Summary of the run as one JSON object.
    """
    flags = flags_set(reconstruct, dict(locals()))
    from skinfield.cli.reconstruct_jobs import Plan
    from skinfield.cli.reconstruct_runs import Many, Wanted, reconstruct_many, reconstruct_one

    folder = _folder_of(recording, output)
    _refuse(flags, OF_MANY if folder is None else OF_ONE, folder)
    if not recording:
        raise InputError("RECORDING is missing, expected one recording or more")
    results = any(_is_results(each) for each in recording)
    if results and (folder is not None or len(recording) > 1):
        raise InputError(
            f"{ENDING} folders are results already, expected recordings for {folder}, or one "
            "folder of results"
        )
    if layout is None and recording[0].lower().endswith(LIVE):
        layout = recording[0]
    if layout is None and not results:
        raise InputError("--skin is missing, expected a layout file, or a generator by name")
    plan = None
    if layout is not None and not results:
        plan = Plan.of(layout, patch, counts, elastomer, model)
    if plan is not None and folder is not None:
        many = Many(recording, folder, processes(workers), scheduler, store_fields)
        reconstruct_many(many, plan, as_json)
        return
    for name in (*output, fields, summary):
        check_output("--output", name, force)
    check_picture("--plot", plot, force)
    if plan is None:
        _refuse_without_effect(flags, output)
    wanted = Wanted(output, fields, summary, plot, reading, slice_)
    reconstruct_one(recording[0], plan, wanted, as_json)


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
    return recording.rstrip("/").lower().endswith(ENDING) and Path(recording).is_dir()


def _refuse(flags: list[tuple[str, str]], names: tuple[str, ...], folder: Path | None) -> None:
    """Options of the other way to work."""
    odd = [text for name, text in flags if name in names]
    if odd and folder is None:
        raise InputError(
            f"{', '.join(odd)} would have no effect: expected -o DIR, a name without an ending, "
            "into which workers write"
        )
    if odd:
        raise InputError(
            f"{', '.join(odd)} would have no effect beside -o {folder}: expected none; ask the "
            f"folders of results in it, such as 'skinfield reconstruct {folder}/NAME{ENDING}'"
        )


def _refuse_without_effect(flags: list[tuple[str, str]], outputs: tuple[str, ...]) -> None:
    """Results know their layout, their model and what counts mean."""
    odd = [text for name, text in flags if name not in OF_RESULTS]
    odd += [f"-o {Path(name).name}" for name in outputs if name.lower().endswith(ENDING)]
    if odd:
        raise InputError(
            f"{', '.join(odd)} would have no effect: expected none beside results, which were "
            "made with theirs; give the recording itself"
        )
