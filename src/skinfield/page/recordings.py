"""Recordings that are begun, ended and opened from the page."""

import os
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import AbstractContextManager
from datetime import datetime
from pathlib import Path
from typing import Any

from skinfield.errors import FileError, InputError
from skinfield.page.source import DataSource
from skinfield.record.launch import ReadyRecorders
from skinfield.record.recorder import RecorderState, read_state

MOST = 99  # files of one second
SILENT = 30.0  # s without a word of a recorder that says something each second, but while it ends
KEPT = 20  # sentences that nobody asked for


class Recordings:
    """Files of one live skin.

    Parameters
    ----------
    name : str
        Of the ring.
    recorder : ReadyRecorders
    replay : function from a path to a DataSource
    folder : Path
        For the files, which are named by the time.
    """

    def __init__(
        self,
        name: str,
        recorder: ReadyRecorders,
        replay: Callable[[Path], DataSource],
        folder: Path,
    ) -> None:
        self._name, self._recorder, self._replay, self._folder = name, recorder, replay, folder
        self._going: tuple[Path, AbstractContextManager[None]] | None = None
        self._files: list[Path] = []
        self._notices: deque[str] = deque(maxlen=KEPT)
        self._lock = threading.Lock()
        self._beginning: Path | None = None
        self._pid: int | None = None  # of the recorder that was begun here

    @property
    def names(self) -> list[str]:
        """That can be opened."""
        return [path.name for path in self._files]

    def prepare(self) -> None:
        """Somebody may begin one soon."""
        self._recorder.prepare()

    def state(self) -> dict[str, Any] | None:
        """What is being recorded, by whomever; None if nothing is."""
        self._recorder.tend()
        pid = self._pid
        if pid is not None and _has_ended(pid):
            self._have_done()
        state, beginning = self._state(), self._beginning
        if state is None or state.finished or _is_gone(state):
            if beginning is None:
                return None
            nothing: dict[str, Any] = {"seconds": 0.0, "bytes": 0, "cycles": 0, "failure": ""}
            return {"file": beginning.name, "mine": True, **nothing}
        fields: dict[str, Any] = {"seconds": state.seconds, "bytes": state.bytes_written}
        fields |= {"cycles": state.cycles}
        fields |= {"failure": state.failure, "mine": self._going is not None}
        return {"file": Path(state.path).name, **fields}

    def notices(self) -> list[str]:
        """Failures since the last time, in sentences."""
        found = []
        while self._notices:
            found.append(self._notices.popleft())
        return found

    def _state(self) -> RecorderState | None:
        try:
            return read_state(self._name)
        except FileError:
            return None

    def _have_done(self) -> None:
        """Have done with what was begun here, and whose recorder ended by itself: tell failures."""
        going = self._take()
        if going is not None:
            try:
                self._finish(*going)
            except InputError as error:
                self._notices.append(str(error))

    def _take(self) -> tuple[Path, AbstractContextManager[None]] | None:
        """What goes on, for whoever asks first: it ends it."""
        with self._lock:
            going, self._going, self._pid = self._going, None, None
        return going

    def _finish(self, path: Path, going: AbstractContextManager[None]) -> None:
        try:
            going.__exit__(None, None, None)
        finally:
            if path.exists():
                self._files.append(path)

    def begin(self) -> dict[str, Any]:
        """Begin one.

        Raises
        ------
        InputError
            If one goes on, or cannot be begun.
        """
        if self.state() is not None or self._going is not None:
            raise InputError("a recording is going on, expected none: end it first")
        path = self._new_path()
        going = self._recorder(path)
        self._beginning = path  # it is told at once, and may take a second
        try:
            going.__enter__()
        finally:
            self._beginning = None
        state = self._state()
        with self._lock:
            self._going = path, going
            if state is not None and Path(state.path).name == path.name:
                self._pid = state.pid
        return {"file": path.name}

    def _new_path(self) -> Path:
        stem = f"{self._name}-{datetime.now():%Y%m%d-%H%M%S}"
        for more in ("", *(f"-{number}" for number in range(2, MOST))):
            path = self._folder / f"{stem}{more}.mcap"
            if not path.exists():
                return path
        raise InputError(f"{self._folder} has {MOST} files of this second, expected fewer")

    def end(self) -> dict[str, Any]:
        """End the one that was begun here; its file can be opened, as far as it goes.

        Raises
        ------
        InputError
            If none was, or its recorder failed: with the way to save what is in the file.
        """
        going = self._take()
        if going is None:
            raise InputError("no recording was begun on this page, expected one that goes on")
        self._finish(*going)
        return {"file": going[0].name}

    def open(self, name: str) -> DataSource:
        """Open one of `names`."""
        for path in self._files:
            if path.name == name:
                return self._replay(path)
        known = ", ".join(self.names) or "none yet"
        raise InputError(f"recording is {name!r}, expected one of this page's: {known}")

    def close(self) -> None:
        """End what was begun, and what stands ready."""
        self._recorder.close()
        if self._going is not None:
            self.end()


def _is_gone(state: RecorderState) -> bool:
    """Whether whoever records is no more, or has not said a word for too long."""
    if _has_ended(state.pid):
        return True
    try:
        os.kill(state.pid, 0)
    except (ProcessLookupError, OverflowError):
        return True
    except OSError:  # another user's
        pass
    return time.time_ns() - state.told_ns > SILENT * 1e9


def _has_ended(pid: int) -> bool:
    """Whether a process that was started here has ended, though nobody has asked how."""
    try:
        return os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
    except (AttributeError, OSError, OverflowError):  # not started here
        return False
