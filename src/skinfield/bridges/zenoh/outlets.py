"""The publishers, answers and sign of life of one engine in a zenoh session."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import Any

from skinfield.bridges.zenoh.keys import Part
from skinfield.bridges.zenoh.session import load_zenoh

JSON, BYTES = "application/json", "application/octet-stream"
WHOLE = {  # what is published of an engine: kind of bytes, and priority
    "contacts": (JSON, "INTERACTIVE_HIGH"),
    "estimate": (BYTES, "DATA"),
    "raw": (BYTES, "DATA"),
    "status": (JSON, "DATA_LOW"),
    "health": (JSON, "DATA_LOW"),
}
OF_PATCH = ("contacts", "raw")


class Outlets:
    """Publishers of one engine; nothing is made for keys that nobody reads.

    All drop what cannot be sent at once: each message is whole, so the next makes up for it, and a
    reader that hangs holds up nobody.

    Parameters
    ----------
    session : zenoh.Session
    part : Part
    patches : sequence of str
    """

    def __init__(self, session: Any, part: Part, patches: Sequence[str]) -> None:
        self._session, self._part = session, part
        self._token: Any = None
        self._publishers: dict[str, Any] = {}
        self._patches = {
            what: [self._declare(part.patch_key(name, what), what) for name in patches]
            for what in OF_PATCH
        }
        for what in WHOLE:
            self._publishers[what] = self._declare(part.key(what), what)

    def _declare(self, key: str, what: str) -> Any:
        zenoh = load_zenoh()
        encoding, priority = WHOLE[what]
        return self._session.declare_publisher(
            key,
            encoding=encoding,
            congestion_control=zenoh.CongestionControl.DROP,
            priority=getattr(zenoh.Priority, priority),
            express=True,  # sent at once, not gathered with others
        )

    def wanted(self, what: str, patch: int | None = None) -> bool:
        """Whether somebody reads this."""
        return bool(self._of(what, patch).matching_status.matching)

    def _of(self, what: str, patch: int | None) -> Any:
        return self._publishers[what] if patch is None else self._patches[what][patch]

    def put(
        self, what: str, data: bytes, head: bytes | None = None, patch: int | None = None
    ) -> None:
        """Send."""
        self._of(what, patch).put(data, attachment=head)

    def live(self, alive: bool) -> None:
        """Show that the engine lives, or take that back."""
        if alive and self._token is None:
            self._token = self._session.liveliness().declare_token(self._part.key("alive"))
        elif not alive and self._token is not None:
            self._token.undeclare()
            self._token = None

    @contextmanager
    def answering(self, answers: Mapping[str, Callable[[], bytes]]) -> Iterator[None]:
        """Answer queries of these keys as long as the block lasts.

        Parameters
        ----------
        answers : mapping from what follows the engine's name in the key to a function
            Called in a thread of zenoh.
        """
        made = []
        try:
            for what, answer in answers.items():
                key = self._part.key(what)
                made.append(self._session.declare_queryable(key, _Answer(key, what, answer)))
            yield
        finally:
            for each in made:
                each.undeclare()

    def close(self) -> None:
        """Take everything back."""
        zenoh = load_zenoh()
        self.live(False)
        several = [each for row in self._patches.values() for each in row]
        with suppress(zenoh.ZError):  # of a session that is closed already
            for publisher in (*self._publishers.values(), *several):
                publisher.undeclare()


class _Answer:
    """Answers one key."""

    def __init__(self, key: str, what: str, make: Callable[[], bytes]) -> None:
        self._key, self._make = key, make
        self._encoding = "application/toml" if what.endswith("layout") else JSON

    def __call__(self, query: Any) -> None:
        with query:
            try:
                data = self._make()
            except Exception as error:  # whatever it is, whoever asked must not wait for ever
                query.reply_err(str(error).encode())
                return
            query.reply(self._key, data, encoding=self._encoding)
