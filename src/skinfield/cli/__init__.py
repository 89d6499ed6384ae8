"""The `skinfield` command."""

from skinfield.cli.main import main as main
