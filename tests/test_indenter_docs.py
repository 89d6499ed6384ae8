"""The page on indenters runs as it stands."""

from pathlib import Path

import pytest
from test_readme import ROOT, follow


def test_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("trimesh")
    monkeypatch.chdir(tmp_path)
    assert follow(ROOT / "docs" / "indenters.md") == (6, 4)
    assert "rod 1.0" in capsys.readouterr().out
    for name in ("lean.png", "pyramid.npz", "press.png"):
        assert Path(name).stat().st_size > 10_000
