"""What README and the guide show runs as it stands, and what they link to is there."""

import csv
import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib
import pytest
from command_line import run

import skinfield as sf
from skinfield.calibrate import touch_sampling

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
PAGES = [
    README,
    ROOT / "CONTRIBUTING.md",
    ROOT / "SECURITY.md",
    *sorted((ROOT / "docs").rglob("*.md")),
]
OUTSIDE = "right_foot"  # recordings of others, which are not in the project


def doc(name: str) -> Path:
    """Find a page of the documentation by its name, whichever folder it stands in."""
    (page,) = (page for page in PAGES if page.stem == name)
    return page


def blocks(page: Path) -> Iterator[tuple[str, str, str]]:
    """Language, file name and text of the fenced blocks of a page, in order."""
    fence = re.compile(r"^```(\w*) ?(\S*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
    yield from fence.findall(page.read_text(encoding="utf-8"))


def follow(page: Path, names: dict[str, Any] | None = None) -> tuple[int, int]:
    """Run a page from top to bottom; return how many snippets and commands there were."""
    names = {} if names is None else names
    snippets = commands = 0
    for language, name, text in blocks(page):
        if name:
            Path(name).write_text(text, encoding="utf-8")
        elif language == "python":
            exec(compile(text, str(page), "exec"), names)
            snippets += 1
        elif language == "sh":
            for line in text.replace("\\\n", " ").splitlines():
                if line.startswith("skinfield") and OUTSIDE not in line:
                    line = line.replace("--duration 5 ", "--duration 1 ")
                    run(*shlex.split(line, comments=True)[1:])
                    commands += 1
    return snippets, commands


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.chdir(tmp_path)
    with matplotlib.rc_context({"backend": "agg"}):
        yield


def test_readme_runs_and_says_what_it_finds(capsys: pytest.CaptureFixture[str]) -> None:
    names: dict[str, Any] = {}
    assert follow(README, names) == (1, 3)
    printed = capsys.readouterr().out
    promised = re.findall(r"Contact\((\S+ ± \S+ N)", README.read_text(encoding="utf-8"))
    assert len(promised) == 2
    assert re.findall(r"Contact\((\S+ ± \S+ N)", printed) == promised
    press, contacts = names["press"], names["est"].contacts
    for contact, force, place in zip(
        contacts, press.force[press.peak], press.place[press.peak], strict=True
    ):
        assert contact.normal_force == pytest.approx(force, abs=1.645 * contact.force_std)
        assert contact.position[:2] == pytest.approx(place, abs=0.3e-3)
    assert Path("contacts.csv").read_text(encoding="utf-8").startswith("reading,stamp_ns,")


def test_readme_fits_a_screen_or_two() -> None:
    lines = README.read_text(encoding="utf-8").splitlines()
    assert len(lines) <= 130
    assert max(map(len, lines)) <= 200


def test_first_press_runs_and_finds_both_balls(capsys: pytest.CaptureFixture[str]) -> None:
    names: dict[str, Any] = {}
    assert follow(doc("first-press"), names) == (6, 3)
    forces = [contact.normal_force for contact in names["press"].contacts]
    assert forces == pytest.approx([2.0, 1.125], rel=0.03)  # as pressed
    said = capsys.readouterr().out
    for line in re.findall(
        r"^(?:Contact|Patch|Layer|Recording)\(.*$", doc("first-press").read_text(), re.M
    ):
        assert line in said, "the page shows another answer"
    highest = re.search(r"([\d.]+) N at most", said)  # in the file that the command wrote
    assert highest is not None
    assert float(highest[1]) == pytest.approx(3.125, rel=0.1)


@pytest.mark.parametrize(
    ("page", "snippets"),
    [
        ("contacts", 1), ("uncertainty", 1), ("track", 2), ("design", 1),
        ("batch", 2), ("icub", 1), ("packet", 1), ("cyskin", 2), ("hardware", 2), ("settings", 1),
    ],
)  # fmt: skip
def test_page_runs_from_top_to_bottom(page: str, snippets: int) -> None:
    assert follow(doc(page)) == (snippets, 0)


def test_own_array_is_made_and_its_presses_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (("BURN", 20), ("ROUNDS", 4), ("SAMPLES", 3)):  # near enough, and quick
        monkeypatch.setattr(touch_sampling, name, value)
    assert follow(ROOT / "docs" / "tutorials" / "own-array.md") == (2, 5)
    with Path("contacts.csv").open(encoding="utf-8") as lines:
        found = [row for row in csv.DictReader(lines) if float(row["time_s"]) > 4.3]
    place = min(found, key=lambda row: abs(float(row["time_s"]) - 4.5))  # in the second press
    assert float(place["x_m"]) == pytest.approx(7e-3, abs=0.4e-3)
    assert float(place["y_m"]) == pytest.approx(-3e-3, abs=0.4e-3)
    assert float(place["force_N"]) == pytest.approx(2.0, rel=0.3)  # relative: by guessed values
    assert sf.load_calibration("my_skin_cal.toml").thickness == pytest.approx(2e-3, rel=0.1)


def test_setup_commands_are_those_of_the_script() -> None:
    from runpy import run_path

    known = run_path(str(ROOT / "dev.py"))["COMMANDS"]
    for page in PAGES:
        named = re.findall(r"python3 dev\.py (\w+)", page.read_text(encoding="utf-8"))
        assert set(named) <= set(known), page.name
    lines = [text.strip() for language, _, text in blocks(README) if language == "sh"]
    assert lines[:2] == ["python3 dev.py demo", "python3 dev.py test"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_take_what_pages_give_them(page: Path) -> None:
    """Also those that need hardware, or run until they are stopped."""
    from skinfield.cli.main import app_for

    for language, _, text in blocks(page):
        for line in text.replace("\\\n", " ").splitlines() if language == "sh" else ():
            if line.startswith("skinfield "):
                words = shlex.split(re.split(r" [|>&] ?", line)[0], comments=True)[1:]
                app_for(words).parse_args(words, exit_on_error=False)  # raises


def anchors(page: Path) -> set[str]:
    """Anchors of the headings of a page, as they are made of their words."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    heads = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8"))
    for link in links:
        if link.startswith(("https://", "http://")):
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), f"{page.name} links to {link}, which is not there"
        if anchor:
            assert anchor in anchors(target), f"{page.name} links to {link}: no such heading"


def test_no_line_of_a_page_is_a_comment() -> None:
    for page in PAGES:
        lines = re.sub(r"^```.*?^```$", "", page.read_text("utf-8"), flags=re.M | re.S)
        lost = re.findall(r"^\s*%.*", lines, re.MULTILINE)  # MyST leaves it out
        assert not lost, f"{page.name}: {lost[0]!r} begins with %: break the line elsewhere"


def test_pictures_are_small_and_used() -> None:
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    pictures = list((ROOT / "docs" / "images").glob("*"))
    assert pictures
    for picture in pictures:
        assert picture.stat().st_size < 400_000, picture.name
        assert f"images/{picture.name}" in text, f"{picture.name} is on no page"
