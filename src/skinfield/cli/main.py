"""The command's entry point: subcommands are loaded when they are called."""

import click


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(package_name="skinfield")
def main() -> None:
    """Turn the readings of robot skin into force, deformation and contacts."""
