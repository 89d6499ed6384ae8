"""Controller of the page of skins elsewhere: which are shown, and why others are not."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from skinfield.bridges.zenoh.source import ZenohSource
from skinfield.page.controller import Controller
from skinfield.page.source import DataSource, EngineView

if TYPE_CHECKING:
    from skinfield.bridges.zenoh.discovery import ZenohSources

NOBODY = "no skin was heard of yet: does one run with --zenoh, where this machine reaches it?"


class RemoteController(Controller):
    """See `Controller`."""

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
        return [
            EngineView(source.latest(), isinstance(source, ZenohSource) and source.gone, True)
            for source in sources
        ]
