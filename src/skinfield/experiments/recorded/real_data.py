"""Recorded data beside the models: the error is stated, and nothing is tuned to them."""

from collections.abc import Callable, Iterator
from pathlib import Path

from skinfield.experiments.recorded.fabric import fabric_taxel
from skinfield.experiments.recorded.finding import AbsentData, Finding
from skinfield.experiments.recorded.foot import foot_on_the_ground
from skinfield.experiments.recorded.tables import layer_tables
from skinfield.experiments.recorded.tension import stretched_elastomer
from skinfield.experiments.section import Picture, Section, Table

# Each takes the folder of all the data. One more kind is one file, and one line here.
FINDINGS: tuple[tuple[str, Callable[[Path], Finding]], ...] = (
    ("foot", foot_on_the_ground),
    ("tables", layer_tables),
    ("elastomer", stretched_elastomer),
    ("fabric", fabric_taxel),
)


def findings(folder: Path | str) -> Iterator[Finding | AbsentData]:
    """What each recording says, or which file it lacks.

    Parameters
    ----------
    folder : path
        With `icub-foot-tipping`, `tables`, `elastomer-tensile` and so on below it.

    Raises
    ------
    FileError
        If a file is there and cannot be used.
    """
    for _, make in FINDINGS:
        try:
            yield make(Path(folder))
        except AbsentData as absent:
            yield absent


def sections(folder: Path | str) -> tuple[Section, ...]:
    """The same as sections of the report; what is absent says so."""
    made = []
    for (name, _), found in zip(FINDINGS, findings(folder), strict=True):
        if isinstance(found, AbsentData):
            title = f"Recorded data: {name}"
            made.append(
                Section(name=f"real-{name}", title=title, claim="", sentences=(str(found),))
            )
        else:
            made.append(section_of(found))
    return tuple(made)


def section_of(finding: Finding) -> Section:
    """A finding as a section of the report."""
    pictures: tuple[Picture, ...] = ()
    if finding.figure is not None:
        pictures = (Picture("series", finding.caption, finding.figure()),)
    tables: tuple[Table, ...] = ()
    if finding.rows:
        columns = tuple(finding.rows[0])
        rows = tuple(tuple(row.values()) for row in finding.rows)
        tables = (Table("numbers", finding.title, columns, rows),)
    return Section(
        name=f"real-{finding.name}",
        title=f"Recorded data: {finding.title}",
        claim="",
        sentences=(*finding.sentences, f"Data: {finding.source}."),
        pictures=pictures,
        tables=tables,
    )
