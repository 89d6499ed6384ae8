"""The page of `skinfield run`: what it shows, and what may be ordered from it."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from skinfield.cli.page_options import page_settings
from skinfield.cli.run_options import LIVE_SOLVERS, live_solver
from skinfield.errors import SkinfieldError


class Here:
    """The feed of the skin that runs here, which a new ring under its name takes the place of.

    Parameters
    ----------
    name : str
        Of the ring.
    """

    def __init__(self, name: str) -> None:
        from skinfield.viewer.live_feed import LiveFeed

        self._name = name
        self._feed = LiveFeed(name)

    @property
    def feed(self) -> Any:
        """The newest."""
        return self._feed

    def feeds(self) -> Sequence[Any]:
        """The feed, looked at whether there is a newer one."""
        from skinfield.viewer.live_feed import LiveFeed

        if self._feed.replaced:
            with suppress(SkinfieldError):  # it is being made anew
                self._feed = LiveFeed(self._name)  # the old one goes with its last reader
        return (self._feed,)


@contextmanager
def page_of(given: dict[str, Any], name: str, supervisor: Any, virtual: Any) -> Iterator[Any]:
    """Serve the page of the skin that runs here, with its `desk`."""
    from skinfield.cli.ready_recorder import ReadyRecorders
    from skinfield.live.fit_reader import FitReader
    from skinfield.viewer import serve_page
    from skinfield.viewer.live_desk import LiveDesk, Solvers
    from skinfield.viewer.recordings import Recordings

    here, chosen = Here(name), [given["solver"]]
    recorders = ReadyRecorders(name, lambda text: desk.say("warn", text))

    def choose(solver: str) -> None:
        supervisor.reconfigure(solver=live_solver(solver))
        chosen[0] = solver

    desk = LiveDesk(
        lambda: here.feed,
        virtual=virtual,
        recordings=Recordings(name, recorders, _replay, Path()),
        solvers=Solvers(tuple(LIVE_SOLVERS), lambda: chosen[0], choose),
        fit=FitReader(name) if given["fit"] else None,
        tare_seconds=given["tare_s"],
    )
    try:
        with serve_page(page_settings(given), here.feeds, desk) as page:
            yield page
    finally:
        desk.close()


def _replay(path: Path) -> Any:
    from skinfield.viewer.replay_feed import ReplayFeed

    return ReplayFeed(path)
