"""Columns and units of a log, for `skinfield new`: found, asked about, matched with the taxels."""

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from skinfield.cli.calibration_inputs import factor_of
from skinfield.cli.questions import Questions, one_of, positive
from skinfield.cli.report import note
from skinfield.errors import FileError, Floats, InputError
from skinfield.files.recordings import columns as cols
from skinfield.files.recordings import open_recording
from skinfield.files.recordings.columns import Table, shortlist
from skinfield.files.recordings.head import read_head
from skinfield.files.recordings.open import file_of, is_binary, stream_recording
from skinfield.plot import plural
from skinfield.signal.polarity import Polarity, find_polarity
from skinfield.skin import Patch
from skinfield.skin.log import NS, LogSettings, TimeUnit
from skinfield.skin.reading import UNITS

RELATIVE = {"dc", "dcc", "dr", "drr", "delta", "rel", "relative"}  # words in names of columns
MOST_RELATIVE = 2.0  # of |ΔC/C₀|: per cent are more
FEWEST = 20  # readings, that tell rest and noise
ICUB_REST = (225.0, 250.0)  # bytes


@dataclass(frozen=True, kw_only=True)
class LogFlags:
    """What flags say of a log."""

    time: str | None
    time_unit: str | None
    rate_hz: float | None
    columns: str | None
    unit: str | None
    load_cell: str | None


def log_settings_for(
    log: str, flags: LogFlags, ask: Questions, patch: Patch, names: tuple[str, ...]
) -> tuple[LogSettings, Patch]:
    """How a log is read, and the patch with its channels.

    A log of a known format says all by itself, unless columns are named.
    """
    if not (flags.columns or flags.time or flags.rate_hz):
        try:
            stream_recording(log)
            note(f"{log} is of a known format: its columns say what they are")
            return LogSettings(), patch
        except FileError:
            pass  # a table of names of its own
    found = _table(log)
    time, unit, rate = _time(found, flags, ask)
    cell = ask.answer(
        "--load-cell", "Column of a load cell (or none)", flags.load_cell,
        cols.guess_load_cell(found) or "none", found.column, optional=True,
    )  # fmt: skip
    if cell is not None:
        newtons = factor_of(None, "N", (cell,))
        its = "is in N" if newtons == 1.0 else f"1 is taken as {newtons:g} N, by its name"
        note(f"load cell {cell!r}: {its}")
    chosen = ask.answer(
        "--columns", f"Columns of the taxels, of {shortlist(found.names)}", flags.columns,
        cols.guess_columns(found, (time, cell)),
        lambda text: match(
            patch, names, found.columns(_words(found, text), (time, cell)), found.source
        ),
    )  # fmt: skip
    assert chosen is not None
    matched, patch = chosen
    guess, why = _unit(found, matched)
    if flags.unit is None:
        note(f"values of the taxels are taken as {guess}: {why}")
    what = ask.answer(
        "--unit", f"Unit of the taxels ({', '.join(f'{k}: {v}' for k, v in UNITS.items())})",
        flags.unit, guess, one_of(tuple(UNITS)),
    )  # fmt: skip
    settings = LogSettings(
        time=time, time_unit=unit, rate_hz=rate, columns=matched, unit=what or "count",
        load_cell=cell,
    )  # fmt: skip
    return settings, patch


def _table(log: str) -> Table:
    """Table of a log whose columns are named by people."""
    if cols.is_table_of_arrays(log):
        return cols.table_of_arrays(log)[0]
    head = read_head(file_of(Path(log)))
    if is_binary(head):
        stream_recording(log)  # says what is wrong with it
    return cols.read_table(head)


def _words(found: Table, text: str) -> list[str]:
    return [text] if text in found.names else [word.strip() for word in text.split(",")]


def _time(
    found: Table, flags: LogFlags, ask: Questions
) -> tuple[str | None, TimeUnit, float | None]:
    """Column of the times, their unit, and the rate where there is none."""
    time = None
    if flags.rate_hz is not None and flags.time is not None:
        raise InputError("--time and --rate-hz were both given, expected one of them")
    if flags.rate_hz is None:
        guess = cols.guess_time(found)
        if guess is None and flags.time is None and not ask.terminal:
            _refuse_dates(found, next(filter(cols.TIME.fullmatch, found.names), None))
        if guess is None and flags.time is None and not ask.terminal:
            raise InputError(
                f"no column of {found.source} is named as a time, expected --time with one of "
                f"{shortlist(found.names)}, or --rate-hz where readings are evenly spaced"
            )
        time = ask.answer(
            "--time", f"Column of the times, of {shortlist(found.names)} (or none)", flags.time,
            guess or "none", found.column, optional=True,
        )  # fmt: skip
    if time is None:
        rate = ask.answer("--rate-hz", "Readings per second", flags.rate_hz, None,
                          positive("--rate-hz", "readings per second"))  # fmt: skip
        return None, "s", rate
    values = found.numbers(time)
    _refuse_dates(found, time)
    usual, why = cols.time_unit_of(time, values)
    if flags.time_unit is None:
        note(f"times of column {time!r} are taken as {usual}: {why}")
    unit = ask.answer(
        "--time-unit", f"Unit of the times ({', '.join(NS)})", flags.time_unit, usual,
        one_of(tuple(NS)),
    )  # fmt: skip
    assert unit is not None
    cols.check_rate(time, unit, values)
    return time, unit, None


def _refuse_dates(found: Table, time: str | None) -> None:
    """Raise InputError if a column of times holds no number."""
    if time is not None and not np.isfinite(found.numbers(time)).any():
        raise InputError(
            f"column {time!r} of {found.source} holds {found.rows[0][found.names.index(time)]!r}, "
            "expected numbers (s, ms, us or ns), not dates: choose another (--time), or --rate-hz"
        )


def match(
    patch: Patch, names: tuple[str, ...], columns: tuple[str, ...], source: str
) -> tuple[tuple[str, ...], Patch]:
    """Columns in the order of the channels of a patch, and the patch with these channels.

    By name where the taxels have names, else by number in the names, else by order; it is said
    which.

    Raises
    ------
    InputError
        If they are not as many, or a taxel has no column; with both numbers and what is left over.
    """
    taxels = len(patch)
    own = {name: name for name in columns}
    numbered = {
        str(int(found[-1])): name for name in columns if (found := re.findall(r"\d+", name))
    }
    for how, known in (("by name", own), ("by the numbers in their names", numbered)):
        wanted = [name if how == "by name" else _whole(name) for name in names]
        if not wanted or not set(wanted) & set(known):
            continue
        if len(known) < len(columns) and how != "by name":
            break
        missing = [name for name, key in zip(names, wanted, strict=True) if key not in known]
        rest = [name for name in columns if name not in {known.get(key) for key in wanted}]
        if missing:
            raise InputError(
                f"{plural(taxels, 'taxel')} and {plural(len(columns), 'column')} of {source} are "
                f"matched {how}: no column for {plural(len(missing), 'taxel')} "
                f"({shortlist(missing)}), no taxel for {plural(len(rest), 'column')} "
                f"({shortlist(rest) or 'none'}); expected one column per taxel"
            )
        first = known[wanted[0]]
        its = "" if names[0] == first else f": {names[0]} is {first}"
        note(f"taxels and columns are matched {how}{its}")
        if rest:
            note(f"left out, as no taxel is named so: {shortlist(rest)}", "yellow")
        rows = np.arange(taxels)
        return tuple(known[key] for key in wanted), replace(patch, channel=rows, n_channels=taxels)
    if names:
        note(
            f"no column is named as the taxels are ({shortlist(names)}): they are matched by "
            "order, which is to be checked", "yellow",
        )  # fmt: skip
    return _in_order(patch, columns, source)


def _in_order(patch: Patch, columns: tuple[str, ...], source: str) -> tuple[tuple[str, ...], Patch]:
    """Columns and patch where the columns stand in the order of channels, or of taxels."""
    taxels = len(patch)
    if len(columns) == patch.n_channels:
        note(f"columns are matched by order: taxel 0 is {columns[int(patch.channel[0])]}")
        return columns, patch
    if len(columns) != taxels:
        some = "" if patch.n_channels == taxels else f" ({patch.n_channels} channels)"
        left = columns[taxels:]
        over = f"columns {shortlist(left)}" if left else f"taxels {len(columns)} to {taxels - 1}"
        raise InputError(
            f"{source} has {plural(len(columns), 'column')} of taxels, expected {taxels}, "
            f"one for each taxel of {patch.name!r}{some}: {over} are left over; "
            "choose with --columns"
        )
    note(f"columns are matched by order: taxel 0 is {columns[0]}, taxel {taxels - 1} {columns[-1]}")
    return columns, replace(patch, channel=np.arange(taxels), n_channels=taxels)


def _whole(name: str) -> str:
    found = re.findall(r"\d+", name)
    return str(int(found[-1])) if found else name


def _unit(found: Table, names: tuple[str, ...]) -> tuple[str, str]:
    """Unit of the values, by sizes of the first ones and by names; and what tells it."""
    values = np.array([found.numbers(name) for name in names])
    values = values[np.isfinite(values)]
    whole = bool((values == np.rint(values)).all())
    named = [name for name in names if RELATIVE & set(re.findall(r"[^\W\d_]+", name.lower()))]
    if whole and (not named or np.abs(values).max(initial=0.0) > 1.0):
        return "count", "they are whole numbers"
    if named:
        return "dC/C0", f"{named[0]} says so"
    middle = float(np.median(np.abs(values))) if len(values) else 0.0
    if middle > 0.2:
        return "count", f"they are about {middle:.3g}"
    return "dC/C0", f"they rest at about {middle:.3g}, and are no whole numbers"


def check_unit(log: str, settings: LogSettings) -> None:
    """Raise InputError where values are too large for what they were taken for: a guess."""
    if settings.columns and settings.unit == "dC/C0":
        largest = float(np.nanmax(np.abs(open_recording(log, log=settings).counts)))
        if largest > MOST_RELATIVE:
            raise InputError(
                f"values of {log} go to {largest:.3g}, expected at most {MOST_RELATIVE:g} of "
                "dC/C0: divide them by 100 if they are per cent, or say --unit (dC/C0, count, "
                "Pa or 1)"
            )


def load_of(log: str, settings: LogSettings) -> Floats | None:
    """What the load cell of a log measures, N; None without one."""
    if settings.load_cell is None:
        return None
    newtons = factor_of(None, "N", (settings.load_cell,))
    alone = cols.only(settings, settings.load_cell)
    return np.asarray(open_recording(log, log=alone).counts[:, 0] * newtons)


def told_by_presses(log: str, settings: LogSettings) -> tuple[LogSettings, Polarity | None]:
    """Settings with whose counts they are and a guess of their gain, as the presses tell."""
    if not settings.columns or settings.unit != "count":
        return settings, None
    counts: Floats = open_recording(log, log=settings).counts
    if len(counts) < FEWEST:
        raise InputError(
            f"{log} has {plural(len(counts), 'reading')}, expected {FEWEST} or more of the skin at "
            "rest, and some presses"
        )
    low = float(np.nanmin(counts))
    if low < 0.0 or float(np.nanmax(counts)) > 65535.0:
        raise InputError(
            f"values of {log} go from {low:g} to {np.nanmax(counts):g}, expected counts from 0 to "
            "65535 with their rest in them: log them before it is taken off, or add one number "
            "to all of them, such as 1000; or say another --unit"
        )
    found = find_polarity(counts, load_of(log, settings))
    rest = float(np.nanmedian(found.rest))
    if rest == 0.0:
        return replace(settings, board="cyskin"), found
    bytes_ = float(np.nanmax(counts)) <= 255.0 and ICUB_REST[0] <= rest <= ICUB_REST[1]
    if bytes_ and found.direction < 0 and (counts == np.rint(counts)).all():
        return replace(settings, board="icub"), found
    board = "plain-falling" if found.direction < 0 else "plain"
    gain = float(f"{found.gain:.4g}")
    return replace(settings, board=board, gain=gain), found  # type: ignore[arg-type]
