"""Report of a calibration: one page with a verdict, figures and a table, in a folder."""

from collections.abc import Iterable, Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from skinfield.cli.report import check_output
from skinfield.errors import FileError
from skinfield.plot import save

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAGE = "report.html"
LOOK = """body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto;
padding: 0 1rem; color: #1b1b1f; background: #fff } img { max-width: 100% }
table { border-collapse: collapse } td { padding: .2rem 1.2rem .2rem 0; vertical-align: top }
.verdict { font-size: 1.15rem; border-left: 4px solid #e24d34; padding-left: 1rem }
caption, figcaption, .quiet { color: #5c5c66; text-align: left }"""


def check_folder(folder: str | None, force: bool) -> None:
    """Raise InputError unless a report can be written into a folder."""
    if folder is not None:
        check_output("--report", Path(folder) / PAGE if Path(folder).is_dir() else folder, force)


def write_report(
    folder: str,
    title: str,
    verdict: str,
    facts: Mapping[str, str],
    figures: Mapping[str, "Figure"],
    notes: Iterable[str] = (),
) -> str:
    """Write the page and its figures (PNG) into a folder; name of the page.

    Raises
    ------
    FileError
        If they cannot be written.
    """
    path = Path(folder)
    try:
        path.mkdir(parents=True, exist_ok=True)
        pictures = []
        for words, figure in figures.items():
            name = "-".join(words.lower().split()) + ".png"
            save(figure, path / name)
            caption = f"<figcaption>{escape(words)}</figcaption>"
            pictures.append(f'<figure><img src="{name}" alt="{escape(words)}">{caption}</figure>')
        rows = "".join(
            f"<tr><td class=quiet>{escape(name)}</td><td>{escape(value)}</td></tr>"
            for name, value in facts.items()
        )
        said = "".join(f"<li>{escape(note)}</li>" for note in notes)
        said = f"<h2>Notes</h2><ul>{said}</ul>" if said else ""
        page = (
            f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}'
            f"</title><style>{LOOK}</style></head>\n<body><h1>{escape(title)}</h1>\n"
            f"<p class=verdict>{escape(verdict)}</p>\n<table>{rows}</table>\n"
            f"{''.join(pictures)}\n{said}</body></html>\n"
        )
        (path / PAGE).write_text(page, encoding="utf-8")
    except OSError as error:
        raise FileError(f"{folder} cannot be written: {error.strerror or error}") from error
    return str(path / PAGE)
