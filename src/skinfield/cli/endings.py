"""How commands that run until they are told to stop are told."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager

ENDINGS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextmanager
def told_to_end() -> Iterator[None]:
    """SIGTERM and SIGHUP end the block as Ctrl-C does.

    What was set before is set again afterwards: programs that are started later would inherit a
    signal that is ignored, and could not be told to end.
    """
    before = {number: signal.getsignal(number) for number in ENDINGS}
    for number in ENDINGS[1:]:
        signal.signal(number, _interrupt)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def end_undisturbed() -> None:
    """From now on an impatient second Ctrl-C must not keep anything from ending."""
    for number in ENDINGS:
        signal.signal(number, signal.SIG_IGN)


def _interrupt(*_: object) -> None:
    raise KeyboardInterrupt
