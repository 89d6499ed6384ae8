"""What commands print: tables, notes and progress."""

from collections.abc import Iterable, Sequence

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from skinfield.fields import Contact

MOST_CONTACTS = 12
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


def plural(count: int, noun: str) -> str:
    """Such as "1 contact" and "3 contacts"."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def table_of_contacts(contacts: Sequence[Contact], title: str) -> Table:
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
