"""Check of a new skin by its log: rest, noise, faults, first contacts, a picture, what is next."""

import shlex
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.cli import options, report
from skinfield.cli.new_log import FEWEST, load_of
from skinfield.cli.report import Column
from skinfield.cli.settings import Elastomer, ModelSettings
from skinfield.errors import Floats, InputError
from skinfield.files.layouts.repair import Finding
from skinfield.plot import plural
from skinfield.signal.polarity import Polarity, idle_under, presses_in
from skinfield.skin import Skin
from skinfield.skin.log import LogSettings

if TYPE_CHECKING:
    from skinfield.cli.reconstruct_jobs import JobPlan
    from skinfield.reconstruct.diagnostics import Survey

MOST_SHOWN = 8  # presses
STANDS_OUT = 8.0  # deviations, of readings in which something presses
APART = 0.2  # s between presses
MOST = 0.5  # of the taxels
LARGE = 24  # taxels: on most of so many, several contacts are one load all over the skin
ENOUGH = 40  # presses, from which on a calibration by touch is sure to begin
FIRST = (
    Column("time s", "time_s", decimals=2), Column("taxel", "taxel"),
    Column("reads", "reading", decimals=3), Column("contacts", "contacts", decimals=0),
    Column("force N", "force_N", decimals=2), Column("± N", "force_std_N", decimals=2),
    Column("x mm", "x_m", 1e3, 1), Column("y mm", "y_m", 1e3, 1), Column("z mm", "z_m", 1e3, 1),
    Column("± mm", "place_std_m", 1e3, 2), Column("load cell", "load_cell", decimals=2),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class NewSkin:
    """A new skin, before it has its name.

    Attributes
    ----------
    skin : Skin
    tables : str
        Its settings, as TOML.
    findings : tuple of Finding
        Of its positions.
    names : tuple of str
        Of its taxels.
    log : str, optional
    settings : LogSettings
    polarity : Polarity, optional
    """

    skin: Skin
    tables: str
    findings: tuple[Finding, ...]
    names: tuple[str, ...]
    log: str | None
    settings: LogSettings
    polarity: Polarity | None


@dataclass(frozen=True, eq=False)
class LogReview:
    """What a log shows of a skin."""

    plan: "JobPlan"
    seconds: Floats  # (T,)
    readings: Floats  # (T, L)
    survey: "Survey"
    rest: Floats  # (L,)
    noise: Floats  # (L,)
    usable: Any  # (L,) bool
    presses: list[int]  # the strongest reading of each
    cell: Floats | None  # (T,)
    rests: bool  # whether the skin is unloaded at some time
    share: Floats  # (T,) of the usable taxels, that are pressed

    @property
    def strongest(self) -> list[int]:
        """Readings of the strongest presses, in order of time."""
        load = np.nanmax(self.readings, axis=1, initial=0.0)
        return sorted(sorted(self.presses, key=lambda at: -load[at])[:MOST_SHOWN])


def finish_new(made: NewSkin, output: str, picture: str | None, as_json: bool) -> None:
    """Check a skin by its log, write its file and its picture, and say what is next."""
    from skinfield.files.layouts import own_toml
    from skinfield.files.layouts.load import lint
    from skinfield.files.pending import write_bytes
    from skinfield.plot import save
    from skinfield.skin.plot import draw_layout

    rows: list[dict[str, Any]] = []
    said: tuple[str, ...] = ()
    with TemporaryDirectory(prefix="skinfield-new-") as folder:
        file = Path(folder) / Path(output).name
        own_toml.write(made.skin, file, made.tables)
        findings = [*made.findings, *lint(file)]
        review = None if made.log is None else review_log(made, str(file))
        if review is not None:
            report.say_notes(review.survey.notes)
            if review.rests:
                with report.compilation(quiet=as_json):
                    rows = first_contacts(review, made.names)
            said = loads_in_words(made, review, rows)
            report.say_notes(said)
        data = file.read_bytes()
    write_bytes(output, data)
    if picture is not None:
        drawn = draw_layout(made.skin) if review is None else _figure(review, made, bool(said))
        save(drawn, picture)
    result = {
        "skin": output, "taxels": len(made.skin[0]), "log": made.log,
        "findings": [f"{each.severity}: {each.message}" for each in findings],
        "notes": [] if review is None else [*review.survey.notes, *said], "first": rows,
        "next": next_commands(made, output, review),
    }  # fmt: skip
    report.finish(as_json, result, (output, picture), _lines(made, review, rows, findings))
    if not as_json:
        for line in _said_next(made, output, review):
            report.say(line)


def review_log(made: NewSkin, file: str) -> LogReview:
    """Rest, noise, faults and presses of the log of a skin whose file is written."""
    from skinfield.cli.reconstruct_jobs import JobPlan
    from skinfield.files import open_recording
    from skinfield.files.recordings.matching import readings_for
    from skinfield.reconstruct.diagnostics import condition

    assert made.log is not None
    plan = JobPlan.of(file, None, options.CountSettings(), Elastomer(), ModelSettings())
    recording = readings_for(open_recording(made.log, log=plan.log), plan.patch)
    quantity = options.quantity_of(plan.model.quantity or options.OF_UNIT[recording.unit])
    cell = load_of(made.log, plan.log)
    how = options.conditioning_of(plan.patch, plan.counts)
    if cell is not None:
        how = replace(how, tare=_unloaded(recording.time, cell))
    layer = options.layer_of(plan.elastomer)
    readings, survey = condition(recording, plan.patch, layer, quantity, how)
    counted = survey.conditioner.calibration
    usable = ~np.isnan(readings).all(axis=0)
    if not usable.any():
        report.say_notes(survey.notes)
        raise InputError(
            f"no taxel of {made.log} can be used, expected readings that change with presses: are "
            f"unit ({recording.unit}) and columns right? say --unit, --columns"
        )
    if counted is not None and counted.unit == "count":
        rest, noise = counted.baseline, counted.noise_std
    else:
        rest, noise = np.nanmedian(recording.counts, axis=0), survey.noise_std
    share = (np.nan_to_num(readings / survey.noise_std) > STANDS_OUT)[:, usable].mean(axis=1)
    load = np.nan_to_num(readings).max(axis=1) if cell is None else np.abs(cell)
    pressed = share > 0.0 if cell is None else ~idle_under(cell)
    rests = int((~pressed).sum()) >= FEWEST or share.max() <= MOST
    gap = max(int(APART * survey.rate), 1)
    presses = presses_in(np.flatnonzero(pressed), load, gap)
    return LogReview(plan, recording.time, readings, survey, rest, noise, usable, presses, cell,
                     rests, share)  # fmt: skip


def _unloaded(seconds: Floats, load: Floats) -> tuple[float, float] | None:
    """Begin and end, s, of the longest stretch in which a load is next to none; None: too short."""
    edges = np.flatnonzero(np.diff(np.r_[False, idle_under(load), False]))
    begin, end = max(zip(edges[::2], edges[1::2], strict=True), key=lambda each: each[1] - each[0],
                     default=(0, 0))  # fmt: skip
    return (seconds[begin], seconds[end - 1]) if end - begin >= FEWEST else None


def first_contacts(review: LogReview, names: tuple[str, ...]) -> list[dict[str, Any]]:
    """A row for each of the strongest presses: when, the strongest taxel, the contact."""
    plan = review.plan
    quantity = options.quantity_of(plan.model.quantity or options.OF_UNIT[plan.log.unit])
    relative = options.is_relative(plan.assumed, plan.log.unit)
    config = options.config_of(
        plan.patch, options.layer_of(plan.elastomer), quantity, review.survey.noise_std, plan.model,
        relative,
    )  # fmt: skip
    alone = len(plan.patch) == 1  # whose place says nothing of a contact
    reconstruct = config.reconstructor() if review.strongest and not alone else None
    rows = []
    for at in review.strongest:
        taxel = int(np.nanargmax(review.readings[at]))
        row: dict[str, Any] = {
            "time_s": float(review.seconds[at]), "taxel": names[taxel] if names else str(taxel),
            "reading": float(review.readings[at, taxel]), "relative": relative,
        }  # fmt: skip
        if reconstruct is not None:
            estimate = reconstruct(review.readings[at])
            wide = bool(review.share[at] > MOST) and int(review.usable.sum()) >= LARGE
            row["all_over"] = wide and len(estimate.contacts) > 1
            if not row["all_over"]:
                if estimate.contacts:
                    row |= report.plain_contacts(estimate.contacts)[0]
                row["contacts"] = len(estimate.contacts)
                row["force_N"] = float(estimate.normal_force)  # of all contacts
        if review.cell is not None:
            row["load_cell"] = float(review.cell[at])
        rows.append(row)
    return rows


def loads_in_words(made: NewSkin, review: LogReview, rows: list[dict[str, Any]]) -> tuple[str, ...]:
    """Why no contacts are told of a log, or of some of its presses."""
    if not review.rests:
        return (
            f"{made.log} has no unloaded part: something presses in every reading, on up to "
            f"{review.share.max():.0%} of the taxels, so that contacts would mean nothing, and the "
            "picture has the readings of the largest load instead; log the skin at rest for two "
            "seconds before it is touched, or name a part that is unloaded: skinfield reconstruct "
            "--tare BEGIN,END",
        )
    wide = [f"{row['time_s']:.2f} s" for row in rows if row.get("all_over")]
    if not wide:
        return ()
    return (
        f"at {', '.join(wide)} most taxels are pressed at once: contacts of such a load mean "
        "nothing; an even pressure that is known calibrates the taxels: skinfield calibrate "
        "pressure",
    )


def _figure(review: LogReview, made: NewSkin, as_map: bool) -> Any:
    from skinfield.signal.plot import draw_log

    names = made.names or tuple(map(str, range(len(review.plan.patch))))
    return draw_log(
        review.plan.patch, names, review.seconds, review.readings, review.rest, review.noise,
        review.usable, review.strongest, quantity=review.survey.conditioner.quantity.symbol,
        unit="counts" if review.plan.log.unit == "count" else review.plan.log.unit,
        loaded=int(np.nansum(review.readings, axis=1).argmax()) if as_map else None,
    )  # fmt: skip


def _lines(
    made: NewSkin, review: LogReview | None, rows: list[dict[str, Any]], findings: list[Finding]
) -> Iterator[report.Shown]:
    """What is known of the skin now."""
    patch = made.skin[0]
    pitch = f", {patch.pitch * 1e3:.3g} mm apart" if len(patch) > 1 else ""
    yield f"{patch.name}: {plural(len(patch), 'taxel')}{pitch}; {_lint_in_words(made, findings)}"
    if review is None:
        return
    span = review.seconds[-1] - review.seconds[0]
    lost = int((~review.usable).sum())
    yield (
        f"{made.log}: {plural(len(review.seconds), 'reading')} in {span:.2f} s "
        f"({review.survey.rate:.4g} per second); rest {_range(review.rest)}, noise "
        f"{_range(review.noise)}; {plural(lost, 'taxel')} left out"
    )
    if made.polarity is not None:
        way = {1: "rise", -1: "fall", 0: "are taken to rise"}[made.polarity.direction]
        unsure = "" if made.polarity.direction else ": too few presses to tell"
        yield f"counts {way} when pressed{unsure}"
    if not review.rests:
        return
    if not rows:
        yield "nothing presses in this log: record one of some presses on the skin at rest"
        return
    relative = any(row["relative"] for row in rows)
    used = [c for c in FIRST if any(row.get(c.key) is not None for row in rows)]
    flat = all(abs(row.get("z_m", 0.0)) < report.FLAT for row in rows)
    used = [c for c in used if c.key != "z_m" or not flat]
    more = f", the {len(rows)} strongest" if len(review.presses) > len(rows) else ""
    title = f"presses in this log: {len(review.presses)}{more}"
    yield report.table_of(title, rows, report.in_scale(used, relative))
    if relative and any("force_N" in row for row in rows):
        yield "forces are relative: true up to one factor, which a known load gives"


def _lint_in_words(made: NewSkin, findings: list[Finding]) -> str:
    """Errors of the file that is written, and those of its source that are none any more."""
    wrong = [each.code for each in findings[len(made.findings) :] if each.severity == "error"]
    before = (each.code for each in made.findings if each.severity == "error")
    mended = len([code for code in before if code not in wrong])
    words = f"lint: {plural(len(wrong), 'error') if wrong else 'no error'}"
    return f"{words}, {mended} mended, see above" if mended else words


def _range(values: Floats) -> str:
    low, high = np.nanmin(values), np.nanmax(values)
    return f"{low:.4g} to {high:.4g}" if high > low else f"{low:.4g}"


def next_commands(made: NewSkin, output: str, review: LogReview | None) -> list[str]:
    """Commands to go on with, as they can be pasted."""
    skin = shlex.quote(output)
    if review is None:
        return [f"skinfield run {skin}"]
    stem = str(Path(output).with_suffix(""))
    log, cal = shlex.quote(str(made.log)), shlex.quote(f"{stem}_cal.toml")
    scale = log if review.cell is not None else "scale.csv"
    force = f"skinfield calibrate force {log} {scale} --skin {skin} -o {cal}"
    if len(made.skin[0]) == 1:
        return [force, f"skinfield calibrate check {cal} {log} {scale} --skin {skin}"]
    contacts = shlex.quote(f"{stem}_contacts.csv")
    answer = f"skinfield reconstruct {log} --skin {skin} -o {contacts}"
    if review.cell is not None:
        return [force, answer]
    presses = log if review.rests and len(review.presses) >= ENOUGH else "presses.csv"
    touch = f"skinfield calibrate touch {presses} --skin {skin} -o {cal}"
    if not review.rests:
        return [touch]
    return [touch, answer] if presses == log else [answer, touch]


def _said_next(made: NewSkin, output: str, review: LogReview | None) -> Iterator[str]:
    yield "next:"
    for command in next_commands(made, output, review):
        yield f"  {command}"
        if " scale.csv " in command:
            yield "    (scale.csv: time_s and force_N of a load cell, beside the log)"
        if " presses.csv " in command:
            yield f"    (presses.csv: {ENOUGH} presses, better a hundred, all over the skin)"
