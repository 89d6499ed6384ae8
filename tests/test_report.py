"""The report: one page that needs nothing else, and files that say the same."""

import csv
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from skinfield.errors import FileError, SkinfieldError
from skinfield.lab.plots import Curve, Panel, Scale, draw_panels
from skinfield.lab.report import (
    SMOKE,
    Chapter,
    Claim,
    Picture,
    Run,
    Table,
    cell_in_words,
    kind_of_verdict,
    listed,
    page_of,
    spread_in_words,
    tied,
    time_in_words,
    write_files,
    write_report,
)

PNG = b"\x89PNG\r\n\x1a\n" + bytes(range(256))
TABLE = Table(
    "numbers", "Caption & <more>",
    [{"name": "a, b", "force (N)": 0.12345, "n": 3}, {"name": "c", "n": 4}],
)  # fmt: skip
SECTION = Chapter(
    name="part",
    title="A part",
    claim="The paper says 0.2 N <b>.",
    sentences=("Found 3 % & more.", "<script>alert(1)</script>"),
    pictures=(Picture("first", "What it shows", PNG),),
    tables=(TABLE, Table("hidden", "Not shown", [{"x (mm)": 1.0}], on_page=False)),
    verdicts=(Claim("4", "claim", "measured", "does not hold"),),
    seconds=12.0,
)
RUN = Run(SMOKE, (SECTION,), {"data": "no folder"}, 75.0)


class Page(HTMLParser):
    """Tags with their attributes, and all text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.words = ""
        self.feed(text)

    def handle_starttag(self, tag, attrs) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in ("meta", "img"):
            self.open.append(tag)

    def handle_endtag(self, tag) -> None:
        assert self.open.pop() == tag, f"</{tag}> closes something else"

    def handle_data(self, data) -> None:
        self.words += data


def test_page_is_well_formed_loads_nothing_and_has_no_id_twice() -> None:
    page = Page(page_of(RUN))
    assert not page.open
    for tag, found in page.tags:
        assert tag not in ("script", "link", "iframe")
        assert not any(name.startswith("on") for name in found)
        assert found.get("src", "data:image/png;base64,").startswith("data:image/png;base64,")
        assert found.get("href", "#").startswith("#") or "://" not in found["href"]
    assert "url(" not in page_of(RUN)
    ids = [found["id"] for _, found in page.tags if found.get("id")]
    links = {f["href"] for tag, f in page.tags if tag == "a" and f["href"].startswith("#")}
    assert len(ids) == len(set(ids))
    assert {"#part", "#headline", "#settings"} <= links <= {f"#{name}" for name in ids}


def test_without_jinja2_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "jinja2", None)
    with pytest.raises(SkinfieldError, match=r"pip install 'skinfield\[lab\]'"):
        page_of(RUN)


def test_text_is_text_whatever_its_signs() -> None:
    page = page_of(RUN)
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in page
    assert "Caption &amp; &lt;more&gt;" in page


def test_page_tells_verdict_missing_parts_time_and_settings() -> None:
    words = " ".join(Page(page_of(RUN)).words.split())
    for part in (
        "does not hold", "Not in this report: data failed: no folder", "1 min 15 s",
        "2 mm, 100 kPa, Poisson's ratio 0.5", "numpy", "0.123",
    ):  # fmt: skip
        assert part in words
    assert "Not shown" not in words


def test_files_hold_pictures_and_tables(tmp_path: Path) -> None:
    write_files(SECTION, tmp_path)
    assert (tmp_path / "first.png").read_bytes() == PNG
    with (tmp_path / "numbers.csv").open(newline="") as file:
        assert list(csv.reader(file)) == [
            [*TABLE.columns],
            ["a, b", "0.12345", "3"],
            ["c", "", "4"],
        ]


def test_a_folder_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="cannot be written"):
        write_report(RUN, tmp_path / "file")


def test_words() -> None:
    cells = (1234.5, -0.012345, 7, None, float("nan"), "x")
    assert [cell_in_words(cell) for cell in cells] == ["1234", "−0.0123", "7", "–", "–", "x"]
    assert listed(["a"]) == "a"
    assert listed(["a", "b", "c"]) == "a, b and c"
    assert spread_in_words([0.1e-3, 0.2e-3], "mm", 1e3) == "0.10 to 0.20 mm"
    assert spread_in_words([2.0, 2.0], "%") == "2.0 %"
    assert [time_in_words(s) for s in (0.512, 12.3, 185)] == ["0.51 s", "12 s", "3 min 5 s"]
    assert tied("0.2 N on 20 × 20 nodes, 3 more") == "0.2\u00a0N on 20\u00a0×\u00a020 nodes, 3 more"
    kinds = ["holds", "holds only in part", "does not hold", "not tried"]
    assert [kind_of_verdict(words) for words in kinds] == ["yes", "partly", "no", "none"]


def test_tables_of_rows_and_panels_in_a_rectangle() -> None:
    table = Table("t", "", [{"a": 1, "b": "x"}, {"a": 2, "c": 0.5}])
    assert table.columns == ["a", "b", "c"]
    assert table.cells == [[1, "x", None], [2, None, 0.5]]
    curve = Curve("one", np.array([1.0, 2.0]), np.array([3.0, 4.0]))
    panel = Panel("title", "note", (curve,), Scale(x="x (mm)", y="y", log_x=True))
    figure = draw_panels([[panel, panel]])
    assert [axes.get_xlabel() for axes in figure.axes] == ["x (mm)", "x (mm)"]
    assert [axes.get_ylabel() for axes in figure.axes] == ["y", ""]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["one"]
