"""Pages on mechanics and electronics run as they stand."""

from pathlib import Path
from typing import Any

import pytest
from test_readme import doc, follow


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def run(page: str) -> tuple[tuple[int, int], dict[str, Any]]:
    """Numbers of snippets and commands, and the names that they left."""
    names: dict[str, Any] = {}
    return follow(doc(page), names), names


def test_mechanics_three_ways() -> None:
    pytest.importorskip("skfem")
    count, names = run("mechanics")
    assert count == (3, 0)
    assert names["small"].depth == pytest.approx(names["state"].depth, rel=3e-4)
    assert names["state"].depth == pytest.approx(0.626e-3, abs=1e-6)
    assert names["state"].contact_radius == pytest.approx(2.626e-3, abs=1e-6)


def test_electronics_give_back_the_press() -> None:
    count, names = run("electronics")
    assert count == (1, 0)
    change, back, kept = names["change"], names["back"], names["sampling"].delivered
    held = (names["rec"].time > 3.0) & (names["rec"].time < 3.9)
    assert change.max() > 0.1
    assert back[held, 3].mean() == pytest.approx(change[kept][held, 3].mean(), abs=0.02)
