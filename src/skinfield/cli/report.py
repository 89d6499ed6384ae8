"""The terminal: tables, notes, progress, files to write, and signals that end a command."""

import json
import os
import signal
import sys
import webbrowser
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from skinfield.errors import InputError

if TYPE_CHECKING:
    from skinfield.estimate import Contact

MOST_CONTACTS = 12
ENDINGS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
FLAT = 5e-5  # m: heights below read 0.0 mm


def console() -> Console:
    """Where tables go: stdout, at least wide enough for a row of numbers."""
    found = Console()
    return Console(width=max(found.width, 100)) if not found.is_terminal else found


def progress() -> Progress:
    """Bar on stderr that goes away when it is done."""
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
    )


def say_notes(notes: Iterable[str]) -> None:
    """Notes to stderr, so that they do not mix with results."""
    shown = Console(stderr=True)
    for note in notes:
        shown.print(f"note: {note}", style="yellow", highlight=False, markup=False)


def say_profile(sentence: str) -> None:
    """Whose skin it is taken for, to stderr."""
    out = Console(stderr=True)
    out.print(sentence, style="dim", highlight=False, markup=False, soft_wrap=True)


def plural(count: int, noun: str) -> str:
    """Such as "1 contact" and "3 contacts"."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def table_of_contacts(contacts: Sequence["Contact"], title: str) -> Table:
    """Contacts with force and place and how sure they are, shape, size and peak.

    The height stands there where one is not 0: on a flat patch it says nothing.
    """
    shown = contacts[:MOST_CONTACTS]
    curved = any(abs(contact.position[2]) > FLAT for contact in shown)
    table = Table(title=title, title_justify="left")
    places = ("x mm", "y mm", "z mm") if curved else ("x mm", "y mm")
    for column in ("#", "force N", "± N", *places, "± mm", "shape"):
        table.add_column(column, justify="left" if column == "shape" else "right")
    for column in ("radius mm", "area mm²", "peak kPa"):
        table.add_column(column, justify="right")
    for index, contact in enumerate(shown, start=1):
        table.add_row(
            str(index),
            f"{contact.normal_force:.2f}",
            f"{contact.force_std:.2f}",
            *(f"{value * 1e3:.1f}" for value in contact.position[: len(places)]),
            f"{contact.place_std * 1e3:.2f}",
            contact.shape,
            f"{contact.radius * 1e3:.1f}",
            f"{contact.area * 1e6:.0f}",
            f"{contact.peak_pressure / 1e3:.1f}",
        )
    if len(contacts) > MOST_CONTACTS:
        table.caption = f"and {len(contacts) - MOST_CONTACTS} weaker ones"
    return table


def say(words: str) -> None:
    """Print a line as it is."""
    console().print(words, highlight=False, markup=False, soft_wrap=True)


def print_text(text: str) -> None:
    """Text on stdout, as it is: for programs that read it, and for people."""
    sys.stdout.write(f"{text}\n")


def print_json(value: Any) -> None:
    """One JSON object on stdout; NaN and infinities become null."""
    from skinfield.files.summary import plain_json

    print_text(json.dumps(plain_json(value, "result"), allow_nan=False))


def check_new(flag: str, name: str | Path | None, force: bool) -> None:
    """Raise InputError if a file of this name is there, unless it is to be written over."""
    if name is not None and not force and Path(name).exists():
        raise InputError(
            f"{flag} is {str(name)!r}, which is there already, expected a new file, or --force to "
            "write over it"
        )


def free_name(name: str) -> str:
    """A file name that is free: the one given, or with a number, as press-2.png."""
    path, number = Path(name), 2
    while path.exists():
        path, number = Path(name).with_stem(f"{Path(name).stem}-{number}"), number + 1
    return str(path)


def check_output(flag: str, name: str | None, ending: str) -> None:
    """Raise InputError unless `name`, where there is one, has the ending and can be written.

    Parameters
    ----------
    flag : str
        As the user gave it, such as "--csv".
    name : str or None
        Of the file.
    ending : str
        Such as ".csv".
    """
    from skinfield.files.pending import pending

    if name is None:
        return
    if not name.lower().endswith(ending):
        raise InputError(f"{flag} is {name!r}, expected a name that ends in {ending}")
    pending(name)  # makes nothing: it says what is wrong with the folder


@contextmanager
def signals_end() -> Iterator[None]:
    """SIGTERM and SIGHUP end the block as Ctrl-C does.

    What was set before is set again afterwards: programs that are started later would inherit a
    signal that is ignored, and could not be told to end.
    """
    before = {number: signal.getsignal(number) for number in ENDINGS}
    for number in ENDINGS[1:]:
        signal.signal(number, _interrupt)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def end_undisturbed() -> None:
    """From now on an impatient second Ctrl-C must not keep anything from ending."""
    for number in ENDINGS:
        signal.signal(number, signal.SIG_IGN)


def _interrupt(*_: object) -> None:
    raise KeyboardInterrupt


def show_address(address: str, console: Console, *, browser: bool, as_json: bool = False) -> None:
    """Print the page's address, and open it where somebody may be looking."""
    if as_json:  # standard output is for the object at the end
        console.print(f"page: {address}", highlight=False, soft_wrap=True)
    else:
        print_text(f"page: {address}")
        sys.stdout.flush()
    if not browser or not _has_screen():
        return
    try:
        webbrowser.open(address)
    except (OSError, webbrowser.Error) as error:
        console.print(f"no browser could be started ({error}): open the page by hand")


def _has_screen() -> bool:
    """Whether a browser would be seen: on a robot it would be one in the terminal."""
    if sys.platform != "linux":
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
