"""`skinfield view`: the page of a recording, or of skins elsewhere."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Any

from rich.console import Console

from skinfield.cli.options import Duration, Page, part
from skinfield.cli.replay import opened, show_page
from skinfield.errors import InputError
from skinfield.settings import PageSettings, ZenohAddresses


def view(
    file: str | None = None,
    /,
    *,
    duration: Duration = None,
    page: Page = PageSettings(),
    zenoh: Annotated[ZenohAddresses, part("Skins elsewhere")] = ZenohAddresses(),
) -> None:
    """Show a recording, or skins that run elsewhere, in the browser.

    FILE is what `skinfield record`, or `run --record`, wrote. It is shown as it was, at any pace
    and from any time on; files that were cut short are shown as far as they go.

    With --zenoh the page shows all skins whose estimates can be reached, side by side as one: see
    `skinfield run --zenoh`.

      skinfield view touch.mcap
      skinfield view touch.mcap --port 8800 --no-browser
      skinfield view --zenoh
      skinfield view --zenoh --zenoh-connect tcp/robot:7447
      skinfield view --zenoh --host 0.0.0.0 --token A-LONG-SECRET

    Recordings of counts alone, such as CSV or a yarpdatadumper log: `skinfield reconstruct`.

    Parameters
    ----------
    file : str, optional
        Recording (.mcap).
    """
    if (file is None) == (not zenoh.zenoh):
        what = "neither was given" if file is None else "both were given"
        raise InputError(
            f"{what}, expected a recording (skinfield view FILE.mcap) or --zenoh; a skin on this "
            "machine has its page where `skinfield run` says"
        )
    if file is not None and zenoh.addressed:
        raise InputError("addresses of zenoh were given with a recording, expected --zenoh alone")
    console = Console(stderr=True)
    shown = _elsewhere(zenoh) if file is None else opened(file, console)
    show_page(shown, page, duration, console)


@contextmanager
def _elsewhere(zenoh: ZenohAddresses) -> Iterator[tuple[Any, Any]]:
    """Sources and controller of skins that are reached over zenoh."""
    from skinfield.bridges.launch import zenoh_sources
    from skinfield.cli.remote import RemoteController

    with zenoh_sources(zenoh) as elsewhere:
        yield elsewhere.sources, RemoteController(elsewhere)
