"""Bridge process, from the inside: how it is told what to do, and how it ends.

`python -m skinfield.bridges.KIND RING --parent PID` reads its settings as one JSON object from
standard input, and writes one line of JSON when it is there: `{"ready": true, ...}`, or
`{"ready": false, "error": "..."}`. After that it writes nothing to standard output.
"""

import argparse
import json
import signal
import sys
import threading
from collections.abc import Callable, Mapping
from typing import TypeVar

from skinfield.errors import SkinfieldError
from skinfield.loop.process_supervisor import end_with, stop_on
from skinfield.settings import value_from_json

MOST = 1 << 20  # bytes of settings
T = TypeVar("T")


def run_child(kind: type[T], serve: Callable[[str, T, threading.Event], None]) -> int:
    """Run a bridge to its end; the exit status.

    Parameters
    ----------
    kind : type
        Of its settings.
    serve : function (name of the ring, settings, event)
        Calls `say_ready` when it is there, and returns soon after the event is set.
    """
    parser = argparse.ArgumentParser()
    parser.add_argument("name")
    parser.add_argument("--parent", type=int)
    given = parser.parse_args()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent, which ends this one
    stop = stop_on(signal.SIGTERM, signal.SIGHUP)
    if given.parent is not None:
        end_with(given.parent)
    try:
        serve(given.name, value_from_json(kind, sys.stdin.buffer.read(MOST)), stop)
    except SkinfieldError as error:
        _say({"ready": False, "error": str(error)})
        return 2
    return 0


def say_ready(**facts: object) -> None:
    """Tell the parent that the bridge is there, with what people may want to know of it."""
    _say({"ready": True} | facts)


def _say(plain: Mapping[str, object]) -> None:
    sys.stdout.write(json.dumps(plain) + "\n")
    sys.stdout.flush()
