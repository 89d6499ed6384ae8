"""The command's entry point: subcommands are loaded when they are called."""

import importlib
from dataclasses import dataclass
from typing import Any

import click

from skinfield.errors import SkinfieldError


@dataclass(frozen=True)
class Lazy:
    """A command that is imported when it is called: `skinfield --help` needs none of them."""

    module: str
    attribute: str
    help: str


COMMANDS = {
    "demo": Lazy("skinfield.cli.demo", "demo", "Press a simulated patch, reconstruct it, draw it."),
    "run": Lazy("skinfield.cli.run", "run", "Bring a robot's skin alive."),
    "view": Lazy(
        "skinfield.cli.view", "view", "Show a recording, or skins elsewhere, in the browser."
    ),
    "status": Lazy("skinfield.cli.status", "status", "What runs, and how well it keeps its time."),
    "tune": Lazy("skinfield.cli.tune", "tune", "Change how a running skin answers."),
    "record": Lazy("skinfield.cli.record", "record", "Record a running skin into one MCAP file."),
    "info": Lazy("skinfield.cli.info", "info", "Say what a recording of a live skin holds."),
    "export": Lazy(
        "skinfield.cli.export", "export", "Turn such a recording into Parquet, CSV, Zarr or HDF5."
    ),
    "recover": Lazy("skinfield.cli.recover", "recover", "Make a whole recording of a damaged one."),
    "replay": Lazy("skinfield.cli.replay", "replay", "Answer a recording again, bit for bit."),
    "reconstruct": Lazy(
        "skinfield.cli.reconstruct", "reconstruct", "Turn a recording into contacts and fields."
    ),
    "calibrate": Lazy("skinfield.cli.calibrate", "calibrate", "Fit the skin to known loads."),
    "press": Lazy("skinfield.cli.press", "press", "Press bodies of any shape on simulated skin."),
    "cases": Lazy("skinfield.cli.cases", "cases", "Write simulated cases to judge solvers by."),
    "validate": Lazy(
        "skinfield.cli.validate", "validate", "Score a solver on cases whose truth is known."
    ),
    "layout": Lazy("skinfield.cli.layout", "layout", "Show, check and convert taxel layouts."),
    "design": Lazy("skinfield.cli.design", "design", "Judge a layout before it is made."),
    "emulate": Lazy(
        "skinfield.cli.emulate", "emulate", "Be a skin: boards that do not exist, on a real bus."
    ),
    "rig": Lazy("skinfield.cli.rig", "rig", "Press a simulated skin on a virtual rig."),
    "bench": Lazy(
        "skinfield.cli.bench", "bench", "Time the solvers here: cost, and error against time."
    ),
    "experiments": Lazy(
        "skinfield.cli.experiments", "experiments", "Make the paper's figures anew, with a report."
    ),
}


class UserError(click.ClickException):
    """An error of the user's input: one paragraph on stderr, exit code 2, no traceback."""

    exit_code = 2


class LazyGroup(click.Group):
    """Group whose commands are imported when called and whose errors are said in a paragraph."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of all commands."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import a command."""
        lazy = COMMANDS.get(cmd_name)
        if lazy is None:
            return None
        command: click.Command = getattr(importlib.import_module(lazy.module), lazy.attribute)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, lazy.help) for name, lazy in COMMANDS.items()])

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; an error that skinfield raises on purpose needs no traceback.

        On one BLAS thread: products of a few megabytes lose more by waking others than they gain.
        """
        from threadpoolctl import threadpool_limits

        try:
            with threadpool_limits(limits=1):
                return super().invoke(ctx)
        except SkinfieldError as error:
            raise UserError(str(error)) from error


@click.group(
    cls=LazyGroup,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(package_name="skinfield")
def main() -> None:
    """Turn the readings of robot skin into force, deformation and contacts."""
