"""What is loaded, since that is what start-up costs; seconds depend on the machine and its load."""

import subprocess
import sys

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


def test_a_loaded_package_would_be_seen() -> None:
    assert "scipy" in loaded_by("import skinfield, scipy")
