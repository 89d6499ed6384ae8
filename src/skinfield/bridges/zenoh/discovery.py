"""Discovery over zenoh: all engines that can be reached, each as a data source."""

import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from skinfield.bridges.zenoh.messages import MOST_JSON, EstimateForm, RemoteCalibration
from skinfield.bridges.zenoh.session import ALL_ALIVE, Keys, ZenohSettings, load_zenoh, open_session
from skinfield.bridges.zenoh.source import ZenohSource
from skinfield.errors import InputError, SkinfieldError

LOOK = 0.2  # s between looks for engines whose description is still wanted
AGAIN = 1.0  # s after an engine did not answer
PATIENCE = 10.0  # s for an answer: layouts may be large
MOST_PARTS = 256  # engines


@dataclass(eq=False)
class _Engine:
    """An engine that was heard of."""

    part: Keys
    alive: bool = True
    source: ZenohSource | None = None
    subscribers: list[Any] = field(default_factory=list)
    next: float = 0.0  # when it may be asked again

    def leave(self) -> None:
        """Hear no more of it."""
        for each in self.subscribers:
            each.undeclare()
        self.subscribers = []


class ZenohSources:
    """Finds engines by their sign of life, and reads what they publish.

    An engine that went away stays, as one that is gone, and goes on when it comes back.

    Attributes
    ----------
    notes : dict of str to str
        Why an engine that can be seen is not shown, by its name.
    """

    def __init__(self, session: Any) -> None:
        self._session = session
        self._engines: dict[str, _Engine] = {}
        self._lock = threading.Lock()
        self._news, self._stop = threading.Event(), threading.Event()
        self.notes: dict[str, str] = {}
        self._thread = threading.Thread(target=self._work, name="zenoh sources", daemon=True)
        self._tokens = session.liveliness().declare_subscriber(
            ALL_ALIVE, self._on_token, history=True
        )
        self._thread.start()

    def sources(self) -> Sequence[ZenohSource]:
        """All engines whose layout is known, by their names.

        Of an engine that was started with another skin there is another source.
        """
        with self._lock:
            known = [each.source for each in self._engines.values() if each.source is not None]
        return tuple(sorted(known, key=lambda source: source.name))

    def wait(self, count: int = 1, timeout: float = 10.0) -> Sequence[ZenohSource]:
        """Wait for so many engines; those that there are when the time is over.

        Parameters
        ----------
        count : int
        timeout : float, s
        """
        end = time.monotonic() + timeout
        while True:
            found = self.sources()
            if len(found) >= count or time.monotonic() > end:
                return found
            time.sleep(0.02)

    def __getitem__(self, name: str) -> ZenohSource:
        """An engine by its name, ROBOT/PART."""
        found = {source.name: source for source in self.sources()}
        if name not in found:
            known = ", ".join(found) or "none so far"
            raise InputError(f"no engine is named {name!r}, expected one of: {known}")
        return found[name]

    def close(self) -> None:
        """Hear no more."""
        self._stop.set()
        self._news.set()
        self._tokens.undeclare()
        self._thread.join()
        with self._lock:
            for engine in self._engines.values():
                engine.leave()

    def _on_token(self, sample: Any) -> None:
        """A sign of life came or went; in a thread of zenoh."""
        try:
            part = Keys.of(str(sample.key_expr))
        except InputError:
            return
        alive = sample.kind == load_zenoh().SampleKind.PUT
        with self._lock:
            engine = self._engines.get(str(part))
            if engine is None:
                if not alive or len(self._engines) >= MOST_PARTS:
                    return
                engine = self._engines[str(part)] = _Engine(part)
            engine.alive, engine.next = alive, 0.0
            if engine.source is not None:
                engine.source.alive = alive
        self._news.set()

    def _work(self) -> None:
        """Ask engines for what is wanted of them."""
        while not self._stop.is_set():
            self._news.wait(LOOK)
            self._news.clear()
            with self._lock:
                engines = list(self._engines.values())
            for engine in engines:
                if engine.alive and not self._stop.is_set() and time.monotonic() >= engine.next:
                    self._look_after(engine)

    def _look_after(self, engine: _Engine) -> None:
        """Ask an engine for its description, or its noise, if that is not known."""
        source, name = engine.source, str(engine.part)
        try:
            if source is None or source.outdated:
                self._join(engine)
            elif source.needs_calibration:
                source.take_calibration(self._calibration(engine.part, source.plan))
        except SkinfieldError as error:
            engine.next = time.monotonic() + AGAIN
            self.notes[name] = str(error)
        else:
            self.notes.pop(name, None)

    def _join(self, engine: _Engine) -> None:
        """Make the source of an engine, in place of an earlier one."""
        part = engine.part
        plan = EstimateForm.of(self._ask(part, "description"))
        if engine.source is not None and engine.source.plan.fingerprint == plan.fingerprint:
            engine.source.outdated = False  # it was asked while it changed
            return
        source = ZenohSource(part, plan, self._calibration(part, plan), self._ask(part, "status"))
        engine.leave()
        zenoh = load_zenoh()
        takes = {
            "estimate": lambda sample: source.take_estimate(
                b"" if sample.attachment is None else sample.attachment.to_bytes(),
                sample.payload.to_bytes(),
            ),
            "status": lambda sample: source.take_status(sample.payload.to_bytes()),
        }
        try:
            for what, take in takes.items():
                made = self._session.declare_subscriber(part.key(what), take)
                engine.subscribers.append(made)
        except zenoh.ZError as error:
            raise InputError(f"{part} cannot be subscribed to: {error}") from error
        with self._lock:
            source.alive, engine.source = engine.alive, source

    def _calibration(self, part: Keys, plan: EstimateForm) -> RemoteCalibration:
        taxels = sum(len(patch) for patch in plan.model_config.skin)
        return RemoteCalibration.of(self._ask(part, "calibration"), taxels)

    def _ask(self, part: Keys, what: str) -> bytes:
        """The answer of an engine to a query.

        Raises
        ------
        InputError
            If there is none, or an error.
        """
        zenoh, failure = load_zenoh(), f"it did not answer within {PATIENCE:g} s"
        try:
            for reply in self._session.get(part.key(what), timeout=PATIENCE):
                if reply.ok is not None:
                    payload = reply.ok.payload
                    if len(payload) > MOST_JSON:
                        raise InputError(f"its {what} has {len(payload)} bytes, that is too many")
                    data: bytes = payload.to_bytes()
                    return data
                failure = reply.err.payload.to_bytes()[:200].decode(errors="replace")
        except zenoh.ZError as error:
            failure = str(error)
        raise InputError(f"{part} was asked for its {what}, expected an answer: {failure}")


@contextmanager
def connect(settings: ZenohSettings | None = None) -> Iterator[ZenohSources]:
    """All live skins that can be reached, as long as the block lasts.

    Parameters
    ----------
    settings : ZenohSettings, optional
        By default those of this machine.

    Raises
    ------
    InputError
        If zenoh is not installed, or cannot start with these settings.
    """
    with open_session(settings or ZenohSettings()) as session:
        sources = ZenohSources(session)
        try:
            yield sources
        finally:
            sources.close()
