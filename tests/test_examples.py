"""Examples of the gallery are of one form; they run when the documentation is built.

What each finds is in its asserts.
"""

import ast
import re
from pathlib import Path

import pytest

GALLERY = Path(__file__).resolve().parents[1] / "examples" / "gallery"
EXAMPLES = sorted(GALLERY.rglob("*.py"))


def test_there_is_a_gallery() -> None:
    assert len(EXAMPLES) >= 16
    assert all((folder / "GALLERY_HEADER.rst").exists() for folder in {e.parent for e in EXAMPLES})


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_example_has_title_figure_and_checked_number(file: Path) -> None:
    text = file.read_text(encoding="utf-8")
    title, line, *_ = (ast.get_docstring(ast.parse(text)) or "").split("\n")
    assert line == "=" * len(title)
    assert re.search(r"^assert ", text, re.MULTILINE)
    assert "plt.show()" in text
    assert "# %%" in text
