"""Output of commands: tables, notes, progress, JSON, files to write, signals that end one."""

import json
import math
import os
import signal
import sys
import threading
import time
import webbrowser
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rich.console import Console, RenderableType
from rich.table import Table

from skinfield.errors import Floats, InputError

if TYPE_CHECKING:
    from skinfield import Contact, Estimate
    from skinfield.compile_progress import CompileProgress
    from skinfield.reconstruct.serialisation import ReconstructorConfig

MOST_CONTACTS = 12
NONE = "–"  # in a cell whose number does not exist
ENDINGS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
BLINK, SAYS = 0.2, 10.0  # s between looks how far a compilation is, and between lines about it
FLAT = 5e-5  # m: heights below read 0.0 mm
Step = Callable[..., None]  # see `progress`
Shown = RenderableType  # what a command prints for people


def console() -> Console:
    """Where tables go: stdout, at least wide enough for a row of numbers."""
    out = Console()
    return Console(width=max(out.width, 100)) if not out.is_terminal else out


@contextmanager
def progress(
    what: str, total: float | None = None, *, quiet: bool = False, counted: bool = True
) -> Iterator[Step]:
    """Bar on stderr that goes away when it is done; without a total it only moves.

    Beside it stand the numbers of what is `counted`, and the time that is left.
    Yields a function of done, total and what, each optional, that moves it there or one step on.
    """
    from rich import progress as rich

    columns = [rich.TextColumn("{task.description}"), rich.BarColumn()]
    if counted:
        columns += [rich.MofNCompleteColumn(), rich.TimeRemainingColumn()]
    out = Console(stderr=True)
    quiet = quiet or not out.is_terminal  # a line would be left
    with rich.Progress(*columns, console=out, transient=True, disable=quiet) as bar:
        task = bar.add_task(what, total=total)

        def step(
            done: float | None = None, total: float | None = None, what: str | None = None
        ) -> None:
            advance = 1.0 if done is None else None
            bar.update(task, total=total, completed=done, advance=advance, description=what)

        yield step


@contextmanager
def compilation(*, quiet: bool = False) -> Iterator["CompileProgress"]:
    """Bar on stderr of what is compiled for this machine, or lines; nothing if nothing is."""
    from skinfield.compile_progress import followed
    from skinfield.compiled import MODE

    with followed("heavy" if MODE.interpreted else "reconstruct") as compiling:
        if quiet:
            yield compiling
            return
        shown = threading.Event()
        thread = threading.Thread(target=_show_compilation, args=(compiling, shown), daemon=True)
        thread.start()
        try:
            yield compiling
        finally:
            shown.set()
            thread.join()


def _show_compilation(compiling: "CompileProgress", over: threading.Event) -> None:
    """Show it as it goes on, until it is over."""
    from skinfield.compile_progress import words

    interactive, said = Console(stderr=True).is_terminal, -math.inf
    with ExitStack() as bars:
        step: Step | None = None
        while not over.wait(BLINK):
            if not compiling.is_going_on:
                continue
            text = words(compiling.seconds_left)
            if interactive:
                step = step or bars.enter_context(progress(text, 1.0, counted=False))
                step(compiling.share, what=text)
            elif time.monotonic() > said + SAYS:
                said = time.monotonic()
                note(text)


def table(title: str | None, words: Sequence[str], numbers: Sequence[str], **look: Any) -> Table:
    """Table with columns of words at the left and of numbers, with their units, at the right."""
    made = Table(title=title, title_justify="left", **look)
    for name in words:
        made.add_column(name, overflow="fold")
    for name in numbers:
        made.add_column(name, justify="right")
    return made


def fixed(value: float | None, decimals: int) -> str:
    """Number with so many decimals, without a minus before nothing; a dash for none."""
    if value is None or not abs(value) < float("inf"):
        return NONE
    return f"{round(float(value), decimals) + 0.0:.{decimals}f}"


def note(text: str, style: str = "dim", where: Console | None = None) -> None:
    """Line on stderr, as it is, so that it does not mix with results."""
    out = where or Console(stderr=True)
    out.print(text, style=style, highlight=False, markup=False, soft_wrap=True)


def say_notes(notes: Iterable[str], where: Console | None = None) -> None:
    """Notes on stderr, marked as such."""
    for text in notes:
        note(f"note: {text}", "yellow", where)


class Column(NamedTuple):
    """Column of a table of rows: heading, key of a row's value, factor from SI to its unit.

    Words, which have no decimals, stand at the left. A column of a fixed width never wraps.
    """

    head: str
    key: str
    factor: float = 1.0
    decimals: int | None = None
    width: int | None = None

    def cell(self, row: Mapping[str, Any]) -> str:
        """Text of a row's value; a dash where it has none."""
        value = row.get(self.key)
        if self.decimals is None or value is None:
            return NONE if value is None else shortened(str(value), self.width)
        return fixed(value * self.factor, self.decimals)


def shortened(text: str, width: int | None) -> str:
    """Text of at most so many letters: both ends, which tell patches of one robot apart."""
    if width is None or len(text) <= width:
        return text
    end = width // 2
    return f"{text[: width - end - 1]}~{text[-end:]}"


def table_of(
    title: str | None, rows: Iterable[Mapping[str, Any]], columns: Sequence[Column], **look: Any
) -> Table:
    """Table of rows in SI units, as JSON has them, too; a row may have a style."""
    made = table(title, (), (), **look)
    for column in columns:
        made.add_column(
            column.head, justify="left" if column.decimals is None else "right", overflow="fold",
            width=column.width, no_wrap=column.width is not None,
        )  # fmt: skip
    for row in rows:
        made.add_row(*(column.cell(row) for column in columns), style=row.get("style"))
    return made


CONTACT = (
    Column("#", "contact", decimals=0), Column("force N", "force_N", decimals=2),
    Column("± N", "force_std_N", decimals=2), Column("x mm", "x_m", 1e3, 1),
    Column("y mm", "y_m", 1e3, 1), Column("z mm", "z_m", 1e3, 1),
    Column("± mm", "place_std_m", 1e3, 2), Column("shape", "shape"),
    Column("radius mm", "radius_m", 1e3, 1), Column("area mm²", "area_m2", 1e6, 0),
    Column("peak kPa", "peak_pressure_Pa", 1e-3, 1),
)  # fmt: skip


def plain_contacts(contacts: Sequence["Contact"]) -> list[dict[str, Any]]:
    """Contacts as JSON has them: force and place and how sure they are, shape, size and peak."""
    return [
        {
            "contact": index,
            "force_N": contact.normal_force,
            "force_std_N": contact.force_std,
            **dict(zip(("x_m", "y_m", "z_m"), map(float, contact.position), strict=True)),
            "place_std_m": contact.place_std,
            "shape": contact.shape,
            "radius_m": contact.radius,
            "area_m2": contact.area,
            "peak_pressure_Pa": contact.peak_pressure,
        }
        for index, contact in enumerate(contacts, start=1)
    ]


HEADS = ("force N", "± N", "peak kPa", "highest N")  # of what is relative until calibrated


def in_scale(columns: Iterable[Column], relative: bool) -> list[Column]:
    """Columns whose heads say so where forces are relative; narrow ones have no unit then."""
    made = []
    for each in columns:
        if relative and each.head in HEADS:
            name = each.head.split()[0]
            each = each._replace(head=name if each.width else f"{name} rel.")
        made.append(each)
    return made


def table_of_contacts(contacts: Sequence["Contact"], title: str, relative: bool = False) -> Table:
    """Contacts; their height stands there where one is not 0: on a flat patch it says nothing.

    The head of forces and pressures says so where they are `relative`.
    """
    first = plain_contacts(contacts[:MOST_CONTACTS])
    curved = any(abs(row["z_m"]) > FLAT for row in first)
    columns = [column for column in CONTACT if curved or column.key != "z_m"]
    made = table_of(title, first, in_scale(columns, relative))
    if len(contacts) > MOST_CONTACTS:
        made.caption = f"and {len(contacts) - MOST_CONTACTS} weaker ones"
    return made


def say(text: str) -> None:
    """Line on stdout, as it is: for programs that read it, and for people."""
    sys.stdout.write(f"{text}\n")


def print_json(value: Any) -> None:
    """One JSON object on stdout; NaN and infinities become null."""
    from skinfield.files.pending import plain_json

    say(json.dumps(plain_json(value, "result"), allow_nan=False))


def finish(
    as_json: bool, value: Any, files: Iterable[str | None] = (), lines: Iterable["Shown"] = ()
) -> None:
    """End of a command: its result as JSON, or lines and tables and which files it wrote."""
    if as_json:
        print_json(value)
        return
    for each in lines:
        say(each) if isinstance(each, str) else console().print(each)
    for name in filter(None, files):
        say(f"wrote {name}")


def check_output(flag: str, name: str | Path | None, force: bool, *endings: str) -> None:
    """Raise InputError unless a file can be written under a name, where there is one.

    `force` is whether one that is there may be written over; without endings, such as ".csv",
    whoever writes it checks them.
    """
    from skinfield.files.pending import pending

    if name is None:
        return
    if not force and Path(name).exists():
        raise InputError(
            f"{flag} is {str(name)!r}, which is there already, expected a new file, or --force to "
            "write over it"
        )
    if endings and not str(name).lower().endswith(endings):
        raise InputError(
            f"{flag} is {str(name)!r}, expected a name that ends in {' or '.join(endings)}"
        )
    pending(name)  # makes nothing: it says what is wrong with the folder


def check_picture(flag: str, name: str | None, force: bool) -> None:
    """Raise InputError unless a figure can be saved under a name, where there is one."""
    if name is not None:
        from skinfield.plot import check_drawable, check_name

        check_drawable()
        check_name(name)
        check_output(flag, name, force)


def picture_if_drawable(name: str) -> str | None:
    """Name of a picture that nobody asked for; None, which is said, without Matplotlib."""
    from skinfield.plot import check_drawable

    try:
        check_drawable()
    except InputError as missing:
        note(f"no picture is made: {missing}", "yellow")
        return None
    return name


def free_name(name: str) -> str:
    """A file name that is free: this one, or with a number, as press-2.png."""
    path, number = Path(name), 2
    while path.exists():
        path, number = Path(name).with_stem(f"{Path(name).stem}-{number}"), number + 1
    return str(path)


def save_picture(
    path: str,
    estimate: "Estimate",
    reading: Floats,
    config: "ReconstructorConfig",
    truth: Sequence[tuple[Any, Any, float]] = (),
    note: str = "",
) -> None:
    """Draw an estimate and its reading, in the units that people read.

    A note stands in place of a latency that is not one of compiled code.
    """
    from skinfield.estimate.plot import draw_estimate
    from skinfield.plot import QUIET, save

    unit = {"1": "%", "Pa": "kPa"}[config.quantity.unit]
    names = {"quantity_name": config.quantity.symbol, "quantity_unit": unit}
    shown = replace(estimate, latency=math.nan) if note else estimate
    figure = draw_estimate(shown, reading, truth=truth, **names)
    figure.text(0.98, 0.02, note, ha="right", color=QUIET, fontsize=8.5)
    save(figure, path)


@contextmanager
def signals_end() -> Iterator[list[int]]:
    """SIGTERM and SIGHUP end the block as Ctrl-C does; gives the signals that came.

    An import that tries another one after any error swallows KeyboardInterrupt, too: whoever
    starts much looks afterwards whether a signal came. What was set before is set again afterwards:
    programs that are started later would inherit a signal that is ignored, and could not be told
    to end.
    """
    before = {number: signal.getsignal(number) for number in ENDINGS}
    came: list[int] = []

    def end(number: int, frame: object) -> None:
        came.append(number)
        raise KeyboardInterrupt

    for number in ENDINGS:
        if number != signal.SIGINT or before[number] is signal.default_int_handler:
            signal.signal(number, end)
    try:
        yield came
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def end_undisturbed() -> None:
    """From now on an impatient second Ctrl-C must not keep anything from ending."""
    for number in ENDINGS:
        signal.signal(number, signal.SIG_IGN)


def has_screen() -> bool:
    """Whether a window can be opened here."""
    return sys.platform != "linux" or bool({"DISPLAY", "WAYLAND_DISPLAY"} & set(os.environ))


def show_address(address: str, where: Console, *, browser: bool, as_json: bool = False) -> None:
    """Print the page's address, and open it where somebody may be looking."""
    if as_json:  # standard output is for the object at the end
        note(f"page: {address}", "", where)
    else:
        say(f"page: {address}")
        sys.stdout.flush()
    if not browser or not has_screen():  # on a robot it would be one in the terminal
        return
    try:
        webbrowser.open(address)
    except (OSError, webbrowser.Error) as error:
        where.print(f"no browser could be started ({error}): open the page by hand")
