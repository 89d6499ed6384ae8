"""What commands print: tables, notes and progress."""

from collections.abc import Iterable, Sequence

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from skinfield.fields import Contact

MOST_CONTACTS = 12


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
    """Contacts with force, place, area, peak."""
    table = Table(title=title, title_justify="left")
    for column in ("#", "force N", "± noise", "x mm", "y mm", "z mm", "area mm²", "peak kPa"):
        table.add_column(column, justify="right")
    for index, contact in enumerate(contacts[:MOST_CONTACTS], start=1):
        x, y, z = contact.position * 1e3
        table.add_row(
            str(index),
            f"{contact.normal_force:.2f}",
            f"{contact.force_std:.2f}",
            *(f"{value:.1f}" for value in (x, y, z)),
            f"{contact.area * 1e6:.0f}",
            f"{contact.peak_pressure / 1e3:.1f}",
        )
    if len(contacts) > MOST_CONTACTS:
        table.caption = f"and {len(contacts) - MOST_CONTACTS} weaker ones"
    return table
