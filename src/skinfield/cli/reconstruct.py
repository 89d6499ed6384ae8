"""`skinfield reconstruct`: recordings to contacts and fields, lists of contacts to tracks."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import numpy as np

from skinfield.cli import options, report
from skinfield.cli.report import Column
from skinfield.cli.settings import Elastomer, ModelSettings
from skinfield.errors import FileError, InputError
from skinfield.estimate.contact_table import scale_of
from skinfield.plot import plural

if TYPE_CHECKING:
    from skinfield import Estimate, Reconstructor
    from skinfield.cli.reconstruct_jobs import JobPlan
    from skinfield.estimate import ContactList, TrackedContact
    from skinfield.files.manifest import Totals
    from skinfield.files.results import Results
    from skinfield.wire.yarp import ContactLog

ENDING = ".skinfield"
OF_ONE = ("fields", "summary", "plot", "reading", "slice_")
OF_MANY = ("workers", "scheduler", "store_fields")
OF_RESULTS = (*OF_ONE, "output", "force", "as_json")  # options for results as well


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
    before (auto, contact, nonnegative) do so within runs of 256, each from the 32 before it;
    where taxels rest is followed from the first reading on.

    Several recordings, or one by several processes, go into a folder: -o DIR gets results of each,
    made window by window by Dask's workers, here or on a cluster. What is complete stands in
    DIR/manifest.json: the same command goes on where a run was ended.

    A log of contact lists (iCub's skin_events) needs no --skin: its contacts are followed from
    reading to reading, and -o writes them as they were sent, with a number that lasts (track).

      skinfield reconstruct foot/data.log --skin right_foot.txt -o contacts.csv --plot foot.png
      skinfield reconstruct press.csv --skin hexagon72 --grid 40 --fields press.npz
      skinfield reconstruct touch.mcap -o contacts.csv
      skinfield reconstruct dump/skin_events -o contacts.csv
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
        Figure of the reading with the highest force: .png, .pdf or .svg.
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
    from skinfield.cli.reconstruct_jobs import JobPlan, reconstruct_many

    folder = _folder_of(recording, output)
    _check_flags(flags, folder)
    if not recording:
        raise InputError("RECORDING is missing, expected one recording or more")
    if any(map(are_contact_lists, recording)):
        odd = [flag for name, flag in flags if name not in OPTIONS]
        if odd:
            _refuse(odd, f"{recording[0]} holds contacts that another program found; expected none")
        _check_alone(recording, folder)
        follow_contacts(recording[0], (layout, patch), output, summary, force, as_json)
        return
    are_results = _are_results(recording, folder)
    if layout is None and recording[0].lower().endswith(options.LIVE):
        layout = recording[0]
    if layout is None and not are_results:
        raise InputError("--skin is missing, expected a layout file, or a generator by name")
    plan = None if are_results else JobPlan.of(str(layout), patch, counts, elastomer, model)
    if plan is not None and folder is not None:
        many = options.processes(workers), scheduler
        reconstruct_many(recording, folder, plan, many, store_fields, as_json)
        return
    _check_outputs(output, fields, summary, plot, force)
    if plan is None:
        _check_flags_of_results(flags, output)
    _reconstruct_one(
        recording[0], plan, output, fields=fields, summary=summary, plot=plot, reading=reading,
        slice_=slice_, as_json=as_json,
    )  # fmt: skip


def _check_flags(flags: list[tuple[str, str]], folder: Path | None) -> None:
    """Raise InputError for those of many recordings without a folder, or of one with it."""
    if folder is None and (odd := [flag for name, flag in flags if name in OF_MANY]):
        _refuse(odd, "expected -o DIR, a name without an ending, into which workers write")
    if folder is not None and (odd := [flag for name, flag in flags if name in OF_ONE]):
        results = f"'skinfield reconstruct {folder}/NAME{ENDING}'"
        _refuse(odd, f"expected none beside -o {folder}; ask its folders of results, as {results}")


def _check_outputs(
    output: Sequence[str], fields: str | None, summary: str | None, plot: str | None, force: bool
) -> None:
    """Raise InputError unless these files can be written."""
    for name in output:
        report.check_output("--output", name, force, ".csv", ".parquet", ENDING)
    report.check_output("--fields", fields, force)
    report.check_output("--summary", summary, force, ".json")
    report.check_picture("--plot", plot, force)


def _check_flags_of_results(flags: list[tuple[str, str]], output: Sequence[str]) -> None:
    """Raise InputError for those of how results are made, where they are made already."""
    odd = [flag for name, flag in flags if name not in OF_RESULTS]
    odd += [f"-o {Path(name).name}" for name in output if name.lower().endswith(ENDING)]
    if odd:
        _refuse(odd, "results were made with theirs; expected none, or the recording itself")


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


def _check_alone(recordings: tuple[str, ...], folder: Path | None) -> None:
    if len(recordings) > 1 or folder is not None:
        raise InputError(
            "logs of contact lists are followed one by one, expected one log and "
            "-o contacts.csv or .parquet"
        )


def _are_results(recordings: tuple[str, ...], folder: Path | None) -> bool:
    """Whether it is a folder of results; raises InputError of one beside anything else."""
    are = any(map(_is_results, recordings))
    if are and (folder is not None or len(recordings) > 1):
        raise InputError(
            f"{ENDING} folders are results already, expected recordings for {folder}, or one "
            "folder of results"
        )
    return are


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


def _reconstruct_one(
    recording: str,
    plan: "JobPlan | None",
    output: Sequence[str],
    *,
    fields: str | None,
    summary: str | None,
    plot: str | None,
    reading: int | None,
    slice_: str | None,
    as_json: bool,
) -> None:
    """Reconstruct a recording, or the results that it is where there is no plan."""
    from skinfield.cli.reconstruct_jobs import place_of, seconds_of, take_in
    from skinfield.files import open_contacts, open_fields, write_summary
    from skinfield.files.results import read_results
    from skinfield.reconstruct.serialisation import CONTACTS

    names = [name for name in (*output, fields, summary, plot) if name]
    stores = [name for name in output if name.lower().endswith(ENDING)]
    if len(stores) > 1:
        raise InputError(f"--output names two {ENDING} folders, expected one at most")
    parent = Path(names[0]).absolute().parent if names else None  # has room
    with ExitStack() as files:
        place = files.enter_context(place_of(stores[0] if stores else None, parent))
        tables = [files.enter_context(open_contacts(name)) for name in output if name not in stores]
        series = files.enter_context(open_fields(fields)) if fields else None
        if plan is None:
            results, skipped = read_results(recording), 0
        else:
            results, skipped = take_in(recording, plan, place)
        if stores and slice_ is None:
            folder = place.part / CONTACTS
            folder.mkdir()
            tables.append(files.enter_context(open_contacts(folder / f"{0:012d}.parquet")))
        report.say_notes(results.notes)
        readings = _readings_of(slice_, len(results), reading)
        if reading is not None and not (tables or fields or summary):
            readings = range(reading, reading + 1)
        totals = _write_parts(results, readings, tables, series)
        totals.peak = totals.peak if reading is None else reading
        best, values = results.estimate(totals.peak), results.values(totals.peak, totals.peak + 1)
        plain = _summary(results, totals, skipped, plan, seconds_of(results, readings))
        when = seconds_of(results, range(totals.peak + 1))
    if summary:
        write_summary(summary, plain)
    report.say_notes((*best.notes, *doubts(results.reconstructor, best)))
    if plot:
        report.save_picture(plot, best, values[0], results.config)
    report.finish(as_json, plain, names, _lines(plain, best, when))


def _write_parts(
    results: "Results", readings: range, tables: Sequence[Any], series: Any | None
) -> "Totals":
    """Write what readings give into tables and a series of fields, part by part; their totals."""
    from skinfield.cli.reconstruct_jobs import parts
    from skinfield.files.manifest import Totals

    totals = Totals()
    with report.progress("reconstructing", len(readings)) as step:
        for part in parts(results, readings, series is not None):
            for each in tables:
                each.write_rows(part.rows)
            if series is not None and part.series is not None:
                series.write_series(results.config.grid, part.series)
            totals.add(part.totals)
            step(totals.readings)
    return totals


def _readings_of(text: str | None, count: int, shown: int | None) -> range:
    """Readings that `--slice` names, that of `--reading` among them."""
    found = range(count)
    if text is not None:
        try:
            low, high = (int(word) if word.strip() else None for word in text.split(":"))
        except ValueError:
            raise InputError(f"--slice is {text!r}, expected two numbers such as 100:200") from None
        found = found[slice(low, high)]
        if not found:
            raise InputError(f"--slice is {text!r}, expected readings of 0:{count}")
    if shown is not None and shown not in found:
        raise InputError(f"--reading is {shown}, expected {found.start} to {found.stop - 1}")
    return found


def _lines(plain: dict[str, Any], best: "Estimate", when: float) -> Iterator[report.Shown]:
    """A line on all readings, and the contacts of one."""
    yield (
        f"{plain['recording']}: {plural(plain['readings'], 'reading')} in "
        f"{plain['duration_s']:.2f} s, {plain['taxels']} taxels of {plain['patch']} "
        f"({plain['taxels_left_out']} left out), {plain['skipped_lines']} lines skipped; "
        f"{plain['latency_ms_per_reading']:.3g} ms per reading"
    )
    force, contacts = float(best.normal_force), plural(len(best.contacts), "contact")
    where = f"reading {plain['highest_force_reading']} at {when:.2f} s"
    unit = "(relative)" if best.relative else "N"
    title = f"{where}: {force:.2f} {unit}, {contacts}, by {best.solver}"
    yield report.table_of_contacts(best.contacts, title, best.relative)


def doubts(reconstructor: "Reconstructor", shown: "Estimate") -> list[str]:
    """What about an estimate cannot be, and what to try."""
    found, grid, layer = [], shown.grid, reconstructor.layer
    if grid.pitch > reconstructor.patch.pitch:
        found.append(
            f"cells of {grid.pitch * 1e3:.1f} mm are wider than the taxels' distance of "
            f"{reconstructor.patch.pitch * 1e3:.1f} mm: a finer --grid gives other forces"
        )
    deepest = float(shown.indentation.max()) / layer.thickness
    if deepest > 0.8:
        found.append(
            f"an indentation of {deepest:.1f} times the thickness is beyond a linear model: the "
            "gain, the modulus or Poisson's ratio does not fit this skin"
        )
    if shown.pressure.min() < -0.5 * shown.pressure.max():
        foam = ": if the elastomer is a foam or a fabric, try --poisson 0.3"
        found.append(
            f"pressure falls to {shown.pressure.min() / 1e3:.0f} kPa beside "
            f"{shown.pressure.max() / 1e3:.0f} kPa, and nothing pulls"
            f"{foam if layer.poisson_ratio > 0.45 else '; linear solvers do not know that'}"
        )
    return found


def _summary(
    results: "Results", totals: "Totals", skipped: int, plan: "JobPlan | None", seconds: float
) -> dict[str, Any]:
    """What `--json` prints and `--summary` writes."""
    count, config = totals.readings, results.config
    kind = type(config.quantity).__name__
    values = {} if plan is None else plan.as_dict()
    return {
        "recording": results.source,
        "readings": count,
        "duration_s": seconds,
        "skipped_lines": skipped,
        "patch": config.patch.name,
        "taxels": len(config.patch),
        "taxels_left_out": len(totals.silent or ()),
        "quantity": next(name for name, each in options.QUANTITIES.items() if each == kind),
        "solver": repr(config.solver),
        "layer": repr(config.layer),
        "grid": list(config.grid.shape),
        "options": {name: value for name, value in values.items() if value is not None},
        "scale": scale_of(config.relative),
        "total_force_N": {"mean": totals.force / count, "highest": totals.highest_force},
        "contacts_per_reading": totals.contacts / count,
        "highest_force_reading": totals.peak,
        "latency_ms_per_reading": totals.seconds / count * 1e3,
        "notes": list(results.notes),
    }


OPTIONS = ("layout", "patch", "output", "summary", "force", "as_json")  # that apply
MOST = 12  # tracks that are shown
TRACKS = (
    Column("track", "track", decimals=0), Column("link", "body_part"),
    Column("skin", "skin_part"), Column("from s", "first_s", decimals=2),
    Column("to s", "last_s", decimals=2), Column("readings", "readings", decimals=0),
    Column("highest force", "highest_force_N", decimals=2),
    Column("moved mm", "moved_m", 1e3, 1),
)  # fmt: skip


def are_contact_lists(recording: str) -> bool:
    """Whether a recording is a log of contact lists; what cannot be read is none."""
    from skinfield.wire.yarp import is_contact_log

    try:
        return is_contact_log(recording)
    except FileError:
        return False


@dataclass
class Summary:
    """What there is to say of the contacts of a log."""

    readings: int = 0
    touched: int = 0
    left_out: int = 0
    start_ns: int = 0
    stamp_ns: int = 0
    tracks: dict[int, dict[str, Any]] = field(default_factory=dict)
    places: dict[int, Any] = field(default_factory=dict)  # where each began

    @property
    def seconds(self) -> float:
        """From the first reading to the latest."""
        return (self.stamp_ns - self.start_ns) / 1e9

    def add(self, reading: "ContactList", tracked: Sequence["TrackedContact"]) -> None:
        """Take in a reading and the tracks that it gave."""
        self.start_ns = self.start_ns if self.readings else reading.stamp_ns
        self.stamp_ns = reading.stamp_ns
        self.readings += 1
        self.touched += bool(reading.contacts)
        self.left_out += len(reading.contacts)
        for one in tracked:
            if not one.is_coasting and one.track_id is not None:
                self.left_out -= 1
                self._add_to(one.track_id, one.measured)

    def _add_to(self, track: int, sent: Any) -> None:
        row = self.tracks.setdefault(
            track,
            {
                "track": track, "body_part": f"{sent.body} {sent.link}", "skin_part": sent.skin,
                "first_s": self.seconds, "readings": 0, "highest_force_N": 0.0, "moved_m": 0.0,
            },
        )  # fmt: skip
        off = sent.position - self.places.setdefault(track, sent.position)
        row["readings"] += 1
        row["last_s"] = self.seconds
        row["highest_force_N"] = max(row["highest_force_N"], sent.normal_force)
        row["moved_m"] = max(row["moved_m"], float(np.linalg.norm(off)))


def follow_contacts(
    recording: str,
    skin: tuple[str | None, str | None],
    output: Sequence[str],
    summary: str | None,
    force: bool,
    as_json: bool,
) -> None:
    """Follow the contacts of a log, and write each reading's with the numbers of their tracks.

    `skin` is a layout and the name of a patch in it, whose taxels' distance counts.
    """
    from skinfield.estimate.contact_list import SPACING
    from skinfield.files import write_summary
    from skinfield.wire.yarp import open_contact_log

    for name in output:
        report.check_output("--output", name, force, ".csv", ".parquet")
    report.check_output("--summary", summary, force, ".json")
    layout, patch = skin
    spacing = SPACING
    if layout is not None:
        spacing = options.patch_of(options.skin_from_text(layout), patch).pitch
    with report.progress("following contacts") as step:
        log = open_contact_log(recording, spacing=spacing, progress=step)
        found = _follow(log, output)
    notes = list(log.notes)
    if found.left_out:
        notes.append(f"{found.left_out} contacts were left out: of very many the strongest count")
    report.say_notes(notes)
    tracks = list(found.tracks.values())
    plain = {
        "recording": log.source,
        "readings": found.readings,
        "readings_with_contact": found.touched,
        "duration_s": found.seconds,
        "skipped_lines": log.skipped,
        "passed_over": log.passed,
        "spacing_m": spacing,
        "tracks": tracks,
        "notes": notes,
    }
    if summary:
        write_summary(summary, plain)
    line = (
        f"{log.source}: {plural(found.readings, 'reading')} in {found.seconds:.2f} s, "
        f"{found.touched} with contact, {log.skipped} lines skipped, {log.passed} passed over"
    )
    report.finish(as_json, plain, [*output, summary], [line, *_table(tracks)])


def _follow(log: "ContactLog", output: Sequence[str]) -> Summary:
    """Follow all contacts of a log into tables; InputError if there is no reading."""
    from skinfield import Tracker
    from skinfield.estimate.contact_table import LISTED_KINDS, rows_from_tracks
    from skinfield.files.tables import TableFile

    tracker, found = Tracker.for_lists(), Summary()
    with ExitStack() as files:
        tables = [files.enter_context(TableFile(name, LISTED_KINDS)) for name in output]
        for reading in log.readings():
            tracked = tracker(reading)
            found.add(reading, tracked)
            place = found.readings - 1, reading.stamp_ns, found.start_ns
            rows = list(rows_from_tracks(tracked, *place)) if reading.contacts else []
            for each in tables if rows else ():
                each.add(list(zip(*rows, strict=True)), len(rows))
        if not found.readings:
            raise InputError(f"{log.source} holds no list of contacts, expected one or more")
    return found


def _table(rows: list[dict[str, Any]]) -> list[report.Shown]:
    """The tracks, those first that lasted longest where there are too many."""
    if not rows:
        return ["no contact"]
    longest = sorted(rows, key=lambda row: -row["readings"])[:MOST]
    made = report.table_of(
        plural(len(rows), "track"), sorted(longest, key=lambda row: row["track"]), TRACKS
    )
    if len(rows) > MOST:
        made.caption = f"and {len(rows) - MOST} shorter ones"
    return [made]
