"""What an experiment hands back: words, pictures and tables, with the numbers they came from."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from skinfield.errors import InputError
from skinfield.experiments.settings import Settings

Cell = str | float | int | None


@dataclass(frozen=True)
class Table:
    """Rows under named columns.

    Parameters
    ----------
    name : str
        Of its CSV file, after the section's.
    caption : str
    columns : tuple of str
        With the unit in brackets, such as "force (N)".
    rows : tuple of tuples
        Text, numbers, or None where there is nothing to say.
    shown : bool
        Whether it stands in the report; else only in its CSV file.
    """

    name: str
    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    shown: bool = True

    def __post_init__(self) -> None:
        for number, row in enumerate(self.rows):
            if len(row) != len(self.columns):
                raise InputError(
                    f"row {number} of table {self.name!r} has {len(row)} cells, expected "
                    f"{len(self.columns)}: one per column {self.columns}"
                )


@dataclass(frozen=True)
class Picture:
    """A figure as the bytes of a PNG file, with its caption."""

    name: str
    caption: str
    png: bytes


@dataclass(frozen=True)
class Verdict:
    """One line of the headline table: a claim, what came out here, and whether it holds."""

    figure: str
    claim: str
    measured: str
    verdict: str


@dataclass(frozen=True)
class Section:
    """One part of the report.

    Parameters
    ----------
    name : str
        Of its files and of its place on the page.
    title : str
    claim : str
        What the paper says, in words; empty where it says nothing.
    sentences : tuple of str
        What was found; every number in them is computed.
    pictures, tables, verdicts : tuples
    seconds : float
        Wall time that it took.
    """

    name: str
    title: str
    claim: str
    sentences: tuple[str, ...]
    pictures: tuple[Picture, ...] = ()
    tables: tuple[Table, ...] = ()
    verdicts: tuple[Verdict, ...] = ()
    seconds: float = 0.0


@dataclass(frozen=True)
class Missing:
    """Why there is no section: what it needs is not at hand."""

    reason: str


@dataclass(frozen=True)
class Part:
    """A share of an experiment that can run beside others and be kept.

    Parameters
    ----------
    name : str
        Letters, digits and ``._+=,-``.
    function : function of `arguments`
        Of the module level; returns what JSON can hold, NaN apart, which becomes None.
    arguments : tuple
    """

    name: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]


@dataclass(frozen=True)
class Experiment:
    """A section yet to be made.

    Parameters
    ----------
    name : str
        By which it is chosen, and its files are named.
    figures : tuple of str
        Of the paper, such as "fig3": it is chosen by these, too.
    make : function of Settings and of `arguments`
        The section, or why there is none. Of the module level: it is sent to other processes.
    arguments : tuple
    parts : function of Settings, optional
        Shares to be computed before; their results, in this order, are the last argument of
        `make`, with None for one that failed.
    alone : bool
        Whether nothing else may run beside it: it measures time.
    """

    name: str
    figures: tuple[str, ...]
    make: Callable[..., Section | Missing]
    arguments: tuple[str, ...] = ()
    parts: Callable[[Settings], Sequence[Part]] | None = None
    alone: bool = False


def section_as_json(section: Section) -> dict[str, Any]:
    """The section without its pictures' bytes, as JSON has it."""
    return {
        "name": section.name,
        "title": section.title,
        "claim": section.claim,
        "sentences": list(section.sentences),
        "seconds": section.seconds,
        "pictures": [{"name": p.name, "caption": p.caption} for p in section.pictures],
        "tables": [
            {
                "name": table.name,
                "caption": table.caption,
                "columns": list(table.columns),
                "rows": [list(row) for row in table.rows],
                "shown": table.shown,
            }
            for table in section.tables
        ],
        "verdicts": [vars(verdict) for verdict in section.verdicts],
    }


def section_from_json(entry: dict[str, Any], png: Callable[[str], bytes]) -> Section:
    """Section of `section_as_json`; `png` finds a picture's bytes by its name."""
    return Section(
        name=entry["name"],
        title=entry["title"],
        claim=entry["claim"],
        sentences=tuple(entry["sentences"]),
        pictures=tuple(Picture(p["name"], p["caption"], png(p["name"])) for p in entry["pictures"]),
        tables=tuple(
            Table(t["name"], t["caption"], tuple(t["columns"]), _rows(t["rows"]), t["shown"])
            for t in entry["tables"]
        ),
        verdicts=tuple(Verdict(**verdict) for verdict in entry["verdicts"]),
        seconds=entry["seconds"],
    )


def _rows(rows: list[list[Cell]]) -> tuple[tuple[Cell, ...], ...]:
    return tuple(tuple(row) for row in rows)
