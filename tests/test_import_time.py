"""What is loaded, since that is what start-up costs; seconds depend on the machine and its load."""

import subprocess
import sys
from pathlib import Path

import pytest

LIST = "; print(*{name.partition('.')[0] for name in set(sys.modules) - before})"


def loaded_by(statement: str) -> set[str]:
    """Packages of others, in a new interpreter, less what it had loaded at its start."""
    code = f"import sys; before = set(sys.modules); {statement}{LIST}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    names = done.stdout.splitlines()[-1].split()
    return {name for name in names if name not in sys.stdlib_module_names} - {"skinfield"}


def test_import_loads_nothing() -> None:
    assert loaded_by("import skinfield") == set()


@pytest.mark.parametrize("arguments", [["--help"], ["--version"]], ids=str)
def test_help_loads_the_command_line_alone(arguments: list[str]) -> None:
    statement = f"from skinfield.cli import app_for; app_for({arguments}).parse_args({arguments})"
    assert not loaded_by(statement) & {"scipy", "numba", "matplotlib", "msgspec", "websockets"}


def test_a_recording_is_reconstructed_without_extras(tmp_path: Path) -> None:
    file, out = tmp_path / "a.csv", tmp_path / "contacts.csv"
    file.write_text("# unit = dC/C0\ntime_s,taxel_0,taxel_1\n0,0.1,0.2\n")
    words = f"reconstruct {file} -o {out} --skin rectangular:rows=1,columns=2".split()
    run = f"from skinfield.cli import app_for as app; app([])({words}, result_action=None)"
    assert (loaded_by(run) & {"pyarrow", "xarray", "dask"}, out.is_file()) == (set(), True)


def test_a_loaded_package_would_be_seen() -> None:
    assert "scipy" in loaded_by("import skinfield, scipy")
