"""Report of the experiments: settings, sections, and one page that needs nothing else."""

import base64
import csv
import hashlib
import platform
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skinfield.errors import FileError, SkinfieldError
from skinfield.lab.bench.machine import versions
from skinfield.lab.paper import FALSE_ALARMS, LAYER, NOISES
from skinfield.plot import METADATA, number

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True)
class Effort:
    """How much is computed.

    Parameters
    ----------
    name : str
    quiet : int
        Readings of an idle patch that set thresholds.
    presses : int
        Noisy readings per indenter, place and load.
    cell : float, m
        Of the truth's grid.
    laps : int
        Of the paper's algorithm per grid, when it is timed.
    grids : tuple of int
        Nodes on a side, where the paper has 10 to 40.
    seed : int
        Of all random numbers.
    """

    name: str
    quiet: int
    presses: int
    cell: float
    laps: int
    grids: tuple[int, ...] = (10, 20, 30, 40)
    seed: int = 0


SMOKE = Effort(name="smoke", quiet=4000, presses=100, cell=0.4e-3, laps=4)
SHORT = Effort(name="short", quiet=100_000, presses=1000, cell=0.2e-3, laps=30)
FULL = Effort(name="full", quiet=400_000, presses=4000, cell=0.125e-3, laps=100)
SIZES = {size.name: size for size in (SMOKE, SHORT, FULL)}  # under a minute, minutes, longer


Cell = str | float | int | None
DPI = 130.0  # of pictures: sharp on a tablet, and a page of a few megabytes


@dataclass(frozen=True)
class Table:
    """Rows under named columns.

    Parameters
    ----------
    name : str
        Of its CSV file, after the section's.
    caption : str
    rows : sequence of dict
        Text, numbers, or None, by column with its unit in brackets, such as "force (N)"; a row
        without a column has nothing to say in it.
    on_page : bool
        Whether it stands in the report; else only in its CSV file.
    """

    name: str
    caption: str
    rows: Sequence[Mapping[str, Any]]
    on_page: bool = True

    @property
    def columns(self) -> list[str]:
        """Each once, in the order of the rows."""
        return list(dict.fromkeys(key for row in self.rows for key in row))

    @property
    def cells(self) -> list[list[Cell]]:
        """A list per row, with a cell for each column."""
        return [[row.get(key) for key in self.columns] for row in self.rows]


@dataclass(frozen=True)
class Picture:
    """A figure as the bytes of a PNG file, with its caption."""

    name: str
    caption: str
    png: bytes

    @classmethod
    def of(cls, name: str, caption: str, figure: "Figure") -> "Picture":
        """Picture of a figure; the same figure gives the same bytes."""
        buffer = BytesIO()
        figure.savefig(buffer, format="png", dpi=DPI, metadata=METADATA[".png"])
        return cls(name, caption, buffer.getvalue())


@dataclass(frozen=True)
class Claim:
    """One line of the headline table: a claim, what came out here, and whether it holds."""

    figure: str
    claim: str
    measured: str
    verdict: str


@dataclass(frozen=True)
class Chapter:
    """One part of the report.

    Parameters
    ----------
    title : str
    claim : str
        What the paper says, in words; empty where it says nothing.
    sentences : tuple of str
        What was found; every number in them is computed.
    pictures, tables, verdicts : tuples
    seconds : float
        Wall time that it took.
    name : str
        Its experiment's, which gives it: of its files and of its place on the page.
    """

    title: str
    claim: str
    sentences: tuple[str, ...]
    pictures: tuple[Picture, ...] = ()
    tables: tuple[Table, ...] = ()
    verdicts: tuple[Claim, ...] = ()
    seconds: float = 0.0
    name: str = ""


@dataclass(frozen=True)
class Experiment:
    """A section yet to be made.

    Parameters
    ----------
    name : str
        By which it is chosen, and its files are named.
    figures : tuple of str
        Of the paper, such as "fig3": it is chosen by these, too.
    make : function of Effort
        The section. Of the module level: it is sent to other processes.
    alone : bool
        Whether nothing else may run beside it: it measures time.
    """

    name: str
    figures: tuple[str, ...]
    make: Callable[[Effort], Chapter]
    alone: bool = False


@lru_cache(maxsize=1)
def program() -> str:
    """Digest of skinfield's own sources."""
    root = Path(__file__).parents[1]
    digest = hashlib.sha256()
    for file in sorted([*root.rglob("*.py"), *root.rglob("*.html")]):
        digest.update(str(file.relative_to(root)).encode() + file.read_bytes())
    return digest.hexdigest()


def spread_in_words(values: Sequence[float], unit: str, scale: float = 1.0) -> str:
    """Such as "0.12 to 0.19 mm": the ends of some numbers."""
    low, high = (number(end * scale, 2) for end in (min(values), max(values)))
    return f"{low if low == high else f'{low} to {high}'} {unit}"


def verdict_of(whole: bool, part: bool = False, no: str = "does not hold") -> str:
    """Whether a claim holds, holds in part, or does not."""
    return "holds" if whole else "holds only in part" if part else no


def listed(words: Sequence[str]) -> str:
    """Such as "a, b and c"."""
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


PAGE = "report.html"
PACKAGES = ("skinfield", "numpy", "scipy", "numba", "matplotlib", "scikit-fem")


@dataclass(frozen=True)
class Run:
    """Everything that a page tells.

    Parameters
    ----------
    settings : Effort
    sections : tuple of Chapter
        In the order of the page.
    failures : mapping of str to str
        Parts that could not be made, each with its reason.
    seconds : float
        Wall time of this run.
    """

    settings: Effort
    sections: tuple[Chapter, ...]
    failures: Mapping[str, str]
    seconds: float


def write_files(section: Chapter, own: Path) -> None:
    """Write a section's PNG and CSV files into its own folder, which is there."""
    for picture in section.pictures:
        (own / f"{picture.name}.png").write_bytes(picture.png)
    for table in section.tables:
        with (own / f"{table.name}.csv").open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([table.columns, *table.cells])


def write_report(run: Run, folder: Path) -> None:
    """Write the page of the whole run.

    Raises
    ------
    FileError
        If it cannot be written.
    """
    page = folder / PAGE
    try:
        page.write_text(page_of(run), encoding="utf-8")
    except OSError as error:
        raise FileError(f"{page} cannot be written: {error.strerror or error}") from error


def page_of(run: Run) -> str:
    """The page: pictures inside, no script, nothing loaded from elsewhere."""
    try:
        from jinja2 import Environment, PackageLoader, StrictUndefined
    except ModuleNotFoundError as error:
        raise SkinfieldError(
            "the report is a page made with jinja2, which is not installed: "
            "pip install 'skinfield[lab]'"
        ) from error

    environment = Environment(
        loader=PackageLoader("skinfield.lab"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "cell": cell_in_words,
        "embedded": lambda png: "data:image/png;base64," + base64.b64encode(png).decode("ascii"),
        "is_number": lambda cell: not isinstance(cell, str),
        "kind": kind_of_verdict,
        "time": time_in_words,
        "tied": tied,
    }
    return environment.get_template("report.html").render(
        run=run,
        settings=settings_in_words(run.settings),
        versions=versions(*PACKAGES),
        machine=f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
    )


def tied(words: str) -> str:
    """Words whose numbers stay on the line of their unit."""
    return re.sub(
        r"(?<=\d) (?=(?:%|N|mm|cm|kPa|ms|s|×)(?![A-Za-z]))|(?<=×) (?=\d)", "\u00a0", words
    )


def cell_in_words(cell: Cell) -> str:
    """Three significant digits, a true minus, and a dash for nothing."""
    if cell is None or cell != cell:
        return "–"
    if isinstance(cell, float):
        large = abs(cell) >= 100
        return (f"{cell:.0f}" if large else f"{cell:.3g}").replace("-", "−")
    return str(cell)


def kind_of_verdict(verdict: str) -> str:
    """Colour of a verdict: yes, partly, no, or none."""
    starts = {"does not": "no", "holds only": "partly", "holds (": "partly", "holds": "yes"}
    return next((kind for start, kind in starts.items() if verdict.startswith(start)), "none")


def time_in_words(seconds: float) -> str:
    """Such as "8.2 s" and "3 min 20 s"."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if minutes else f"{number(seconds, 2)} s"


def settings_in_words(settings: Effort) -> list[tuple[str, str]]:
    """Names and values for the foot of the page."""
    return [
        ("size", f"{settings.name}: {settings.quiet} idle readings, {settings.presses} presses per "
         f"case, cells of {settings.cell * 1e3:g} mm, {settings.laps} laps"),
        ("seed", str(settings.seed)),
        ("layer", f"{LAYER.thickness * 1e3:g} mm, {LAYER.young_modulus / 1e3:g} kPa, Poisson's "
         f"ratio {LAYER.poisson_ratio:g}"),
        ("noise of a reading", f"{NOISES['stress'] / 1e3:g} kPa"),
        ("false alarms", f"{FALSE_ALARMS:g} per idle reading"),
    ]  # fmt: skip
