"""Recordings that are begun, ended and opened from the page."""

import os
import threading
import time
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
    say : function of a sentence
        Told why a recording failed that nobody ended.
    """

    def __init__(
        self,
        name: str,
        recorder: ReadyRecorders,
        replay: Callable[[Path], DataSource],
        folder: Path,
        say: Callable[[str], None],
    ) -> None:
        self._name, self._recorder, self._replay, self._folder = name, recorder, replay, folder
        self._say = say
        self._going: tuple[Path, AbstractContextManager[None]] | None = None
        self._files: list[Path] = []
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
        if self._pid is not None and _has_ended(self._pid):  # by itself
            try:
                self.end()
            except InputError as error:
                self._say(str(error))
        state, mine = self._state(), self._going is not None
        if state is None or _is_gone(state):
            if self._beginning is None:
                return None
            state, mine = RecorderState(path=str(self._beginning)), True
        return {
            "file": Path(state.path).name,
            "seconds": state.seconds,
            "bytes": state.bytes_written,
            "cycles": state.cycles,
            "failure": state.failure,
            "mine": mine,
        }

    def _state(self) -> RecorderState | None:
        try:
            return read_state(self._name)
        except FileError:
            return None

    def record(self, on: bool) -> dict[str, Any]:
        """Begin a recording, or end it."""
        return self.begin() if on else self.end()

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
        with self._lock:  # whoever asks first ends it
            going, self._going, self._pid = self._going, None, None
        if going is None:
            raise InputError("no recording was begun on this page, expected one that goes on")
        path, recorder = going
        try:
            recorder.__exit__(None, None, None)
        finally:
            if path.exists():
                self._files.append(path)
        return {"file": path.name}

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
    """Whether a recording has ended, or whoever records has not said a word for too long."""
    silent = time.time_ns() - state.told_ns > SILENT * 1e9
    return state.finished or silent or bool(state.ended) or _has_ended(state.pid)


def _has_ended(pid: int) -> bool:
    """Whether a process that was started here has ended, though nobody has asked how."""
    try:
        return os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
    except (AttributeError, OSError, OverflowError):  # not started here
        return False
