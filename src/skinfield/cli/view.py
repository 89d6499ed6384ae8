"""`skinfield view`: the page of a recording, or of skins elsewhere."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any

from rich.console import Console

from skinfield.bridges.launch import zenoh_sources
from skinfield.bridges.zenoh.source import ZenohSource
from skinfield.cli.options import Page, part
from skinfield.cli.replay import opened, show_page
from skinfield.errors import InputError, check_positive
from skinfield.page.controller import Controller
from skinfield.page.source import DataSource, EngineView, plain_view
from skinfield.settings import PageSettings, ZenohAddresses

if TYPE_CHECKING:
    from skinfield.bridges.zenoh.discovery import ZenohSources

NOBODY = "no skin was heard of yet: does one run with --zenoh, where this machine reaches it?"


def view(
    file: str | None = None,
    /,
    *,
    duration: float | None = None,
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
    duration : float, s, optional
        Seconds; default until Ctrl-C.
    """
    _check(file, zenoh, duration)
    console = Console(stderr=True)
    shown = _elsewhere(zenoh) if file is None else opened(file, console)
    show_page(shown, page, duration, console)


def _check(file: str | None, zenoh: ZenohAddresses, duration: float | None) -> None:
    """Raise InputError unless it is clear what to show."""
    if (file is None) == (not zenoh.zenoh):
        what = "neither was given" if file is None else "both were given"
        raise InputError(
            f"{what}, expected a recording (skinfield view FILE.mcap) or --zenoh; a skin on this "
            "machine has its page where `skinfield run` says"
        )
    if file is not None and zenoh.addressed:
        raise InputError("addresses of zenoh were given with a recording, expected --zenoh alone")
    if duration is not None:
        check_positive("--duration", duration, "s")


@contextmanager
def _elsewhere(zenoh: ZenohAddresses) -> Iterator[tuple[Any, Any]]:
    """Sources and controller of skins that are reached over zenoh."""
    with zenoh_sources(zenoh) as found:
        yield found.sources, RemoteController(found)


class RemoteController(Controller):
    """See `Controller`.

    Parameters
    ----------
    found : ZenohSources
    """

    def __init__(self, found: "ZenohSources") -> None:
        super().__init__()
        self._found = found
        self._noted: dict[str, str] = {}

    def notices(self) -> list[tuple[str, str]]:
        """See `Controller`; and why an engine that can be seen is not shown, once."""
        notes = dict(self._found.notes)
        for name, why in notes.items():
            if self._noted.get(name) != why:
                self.say("warn", f"{name} is not shown: {why}")
        self._noted = notes
        return super().notices()

    def controls(self) -> dict[str, Any]:
        """See `Controller`; why nothing is shown is told as long as that is so."""
        fields = super().controls()
        if not self._found.sources():
            notes = dict(self._found.notes)
            whys = [f"{name} is not shown: {why}" for name, why in notes.items()]
            fields["busy"] = "; ".join(whys) or NOBODY
        return fields

    def views(self, sources: Sequence[DataSource]) -> list[EngineView]:
        """See `Controller`."""
        return [_view(source) for source in sources]


def _view(source: DataSource) -> EngineView:
    snapshot = source.latest()
    if snapshot is None or not isinstance(source, ZenohSource):
        return plain_view(snapshot)
    return EngineView(snapshot, *source.best(snapshot), old=source.gone)
