"""The `skinfield` command."""

from skinfield.cli.main import app_for as app_for
from skinfield.cli.main import main as main
