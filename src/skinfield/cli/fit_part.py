"""The process that `skinfield run` starts to fit contacts beside the engine."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO

from skinfield.cli.kept import Kept
from skinfield.errors import InputError

ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


class Fit(Kept):
    """The process that fits contacts, started again when it ends.

    Parameters
    ----------
    name : str
        Of the live skin.
    """

    def __init__(self, name: str) -> None:
        super().__init__("the contact fit")
        self._name = name
        self._words: IO[bytes] | None = None

    def spawn(self) -> "subprocess.Popen[bytes]":
        """See `Kept`."""
        from skinfield.live.handover import nameless_file

        self.forget()
        self._words = nameless_file()
        me = str(os.getpid())
        return subprocess.Popen(
            [sys.executable, "-m", "skinfield.live.fit_process", self._name, "--parent", me],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=self._words,
            process_group=0,  # a terminal's Ctrl-C is meant for whoever started it, and ends it
            env=os.environ | ONE_THREAD | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        )

    @property
    def last_words(self) -> str:
        """See `Kept`."""
        from skinfield.live.handover import plain_error, tail_of

        said = "" if self._words is None else tail_of(self._words).strip()
        return f": {plain_error(said.splitlines()[-1])}" if said else ""

    def forget(self) -> None:
        """Close what it said."""
        if self._words is not None:
            self._words.close()


@contextmanager
def start_fit(name: str, wanted: bool = True) -> Iterator[Fit | None]:
    """Fit the contacts of this skin as long as the block lasts.

    It need not succeed: where there is no fit, the engine's own contacts are shown.

    Parameters
    ----------
    name : str
        Of the live skin.
    wanted : bool
        Otherwise nothing is started, and None is given.
    """
    if not wanted:
        yield None
        return
    fit = Fit(name)
    try:
        with fit:
            try:
                fit.begin()
            except InputError as error:
                fit.failure = str(error)
            fit.keep()
            yield fit
    finally:
        fit.forget()
