"""The `skinfield` command as `python -m skinfield`."""

from skinfield.cli import main

main()
