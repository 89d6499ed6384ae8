"""Options of commands that serve the page, and how its address is told."""

import os
import sys
import webbrowser
from collections.abc import Callable
from typing import Any, TypeVar

import click
from rich.console import Console

F = TypeVar("F", bound=Callable[..., Any])


def page_options(function: F) -> F:
    """Where the page is served."""
    for option in (
        click.option("--no-browser", is_flag=True, help="Do not open the page in a browser."),
        click.option(
            "--token", default="", metavar="TEXT",
            help="That the page's address must hold: needed with another --host.",
        ),
        click.option(
            "--host", default="127.0.0.1", show_default=True,
            help="Address to serve the page on; 0.0.0.0 lets others open it.",
        ),
        click.option(
            "--port", type=int,
            help="Of the page; 0 lets the system choose. [default: 8700, or another that is free]",
        ),
    ):  # fmt: skip
        function = option(function)
    return function


def page_settings(given: dict[str, Any]) -> Any:
    """`PageSettings` of the options."""
    from skinfield.viewer import PageSettings
    from skinfield.viewer.settings import PORT

    port = given["port"]
    return PageSettings(
        host=given["host"],
        port=PORT if port is None else port,
        token=given["token"],
        other_port=port is None,
    )


def tell_page(given: dict[str, Any], address: str, console: Console) -> None:
    """Print the page's address, and open it where somebody may be looking."""
    if given.get("as_json"):  # standard output is for the object at the end
        console.print(f"page: {address}", highlight=False, soft_wrap=True)
    else:
        click.echo(f"page: {address}")
        sys.stdout.flush()
    if given["no_browser"] or given.get("headless") or not _has_screen():
        return
    try:
        webbrowser.open(address)
    except (OSError, webbrowser.Error) as error:
        console.print(f"no browser could be started ({error}): open the page by hand")


def _has_screen() -> bool:
    """Whether a browser would be seen: on a robot it would be one in the terminal."""
    if sys.platform != "linux":
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
