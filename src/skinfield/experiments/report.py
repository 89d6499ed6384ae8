"""Sections as files: one folder each, and one page that shows them all and needs nothing else."""

import base64
import csv
import json
import platform
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from skinfield.errors import FileError
from skinfield.experiments.section import Cell, Section, section_as_json, section_from_json
from skinfield.experiments.settings import Settings

PAGE, RESULTS, SECTION = "report.html", "results.json", "section.json"
PACKAGES = ("skinfield", "numpy", "scipy", "numba", "matplotlib", "scikit-fem")


@dataclass(frozen=True)
class Run:
    """Everything that a page tells.

    Parameters
    ----------
    settings : Settings
    sections : tuple of Section
        In the order of the page.
    missing : tuple of str
        Parts that could not be made, each with its reason.
    seconds : float
        Wall time of this run.
    """

    settings: Settings
    sections: tuple[Section, ...]
    missing: tuple[str, ...]
    seconds: float


def write_section(section: Section, own: Path) -> None:
    """Write a section's PNG, CSV and JSON files into its own folder, which is there."""
    for picture in section.pictures:
        (own / f"{picture.name}.png").write_bytes(picture.png)
    for table in section.tables:
        with (own / f"{table.name}.csv").open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerows([table.columns, *table.rows])
    _write_json(own / SECTION, section_as_json(section))


def read_section(own: Path) -> Section:
    """Section as `write_section` wrote it.

    Raises
    ------
    FileError
        If files are missing or are something else.
    """
    try:
        entry = json.loads((own / SECTION).read_text(encoding="utf-8"))
        return section_from_json(entry, lambda picture: (own / f"{picture}.png").read_bytes())
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise FileError(
            f"{own / SECTION} is no section of a report ({error}), expected one that this program "
            "wrote: remove its folder, and it is made again"
        ) from error


def write_report(run: Run, folder: Path) -> Path:
    """Write the page and the JSON file of the whole run; the page's path comes back.

    Raises
    ------
    FileError
        If a file cannot be written.
    """
    page = folder / PAGE
    try:
        folder.mkdir(parents=True, exist_ok=True)
        page.write_text(page_of(run), encoding="utf-8")
        _write_json(
            folder / RESULTS,
            {
                "settings": asdict(run.settings),
                "versions": versions(),
                "seconds": run.seconds,
                "missing": list(run.missing),
                "sections": [section_as_json(section) for section in run.sections],
            },
        )
    except OSError as error:
        raise FileError(f"{page} cannot be written: {error.strerror or error}") from error
    return page


def page_of(run: Run) -> str:
    """The page: pictures inside, no script, nothing loaded from elsewhere."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("skinfield.experiments"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "cell": cell_in_words,
        "embedded": embedded,
        "is_number": is_number,
        "kind": kind_of_verdict,
        "time": time_in_words,
        "tied": tied,
    }
    return environment.get_template("report.html").render(
        run=run,
        settings=settings_in_words(run.settings),
        versions=versions(),
        machine=f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
    )


def embedded(png: bytes) -> str:
    """A picture as an address that holds it."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def tied(words: str) -> str:
    """Words whose numbers stay on the line of their unit."""
    return re.sub(
        r"(?<=\d) (?=(?:%|N|mm|cm|kPa|ms|s|×)(?![A-Za-z]))|(?<=×) (?=\d)", "\u00a0", words
    )


def is_number(cell: Cell) -> bool:
    """Whether a cell stands to the right of its column."""
    return not isinstance(cell, str)


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
    if seconds < 60:
        return f"{seconds:.2g} s" if seconds < 10 else f"{seconds:.0f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s"


def settings_in_words(settings: Settings) -> list[tuple[str, str]]:
    """Names and values for the foot of the page."""
    layer, size = settings.layer, settings.size
    return [
        ("size", size.name),
        ("seed", str(settings.seed)),
        (
            "layer",
            f"{layer.thickness * 1e3:g} mm, {layer.young_modulus / 1e3:g} kPa, Poisson's ratio "
            f"{layer.poisson_ratio:g}",
        ),
        ("noise of a reading", f"{settings.stress_noise / 1e3:g} kPa; {settings.change_noise:g}"),
        ("false alarms", f"{settings.false_alarms:g} per idle reading"),
        ("idle readings", str(size.quiet)),
        ("presses per case", str(size.presses)),
        ("cell of the truth", f"{size.cell * 1e3:g} mm"),
        ("laps of the timing", str(size.laps)),
    ]


def versions() -> dict[str, str]:
    """Of the packages whose numbers these are."""
    found = {}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found


def _write_json(path: Path, entry: dict[str, Any]) -> None:
    text = json.dumps(plain(entry), indent=1, ensure_ascii=False, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")


def plain(value: Any) -> Any:
    """The value as JSON has it: NaN is null, tuples are lists."""
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [plain(entry) for entry in value]
    if isinstance(value, float) and value - value != 0:
        return None
    return value
