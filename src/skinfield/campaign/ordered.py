"""One function over many pieces in processes, the answers in order; knows no physics."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from typing import Any, TypeVar

from skinfield.campaign.runner import _one_thread_each, _pool
from skinfield.errors import SkinfieldError, check_count

P = TypeVar("P")
R = TypeVar("R")
AHEAD = 2  # pieces per process that are under way: bounds the memory of answers that wait
_made: dict[int, Callable[[Any], Any]] = {}


def in_order(
    make: Callable[..., Callable[[P], R]],
    arguments: tuple[Any, ...],
    pieces: Iterable[P],
    workers: int,
) -> Iterator[R]:
    """Answers to all pieces, in their order.

    Processes start afresh and have one thread each for the numerical libraries. After Ctrl-C, or
    when the iterator is closed, pieces that are under way end and the others never begin.

    Parameters
    ----------
    make : callable
        Of the module level. ``make(*arguments)``, called once in each process, returns the
        function of a piece: what it prepares serves all pieces of that process.
    arguments : tuple
        Like pieces and answers, of what can be pickled.
    pieces : iterable
        Taken as they are needed.
    workers : int
        Processes; with 1 all is done in this one.

    Raises
    ------
    SkinfieldError
        With the piece and what went wrong, if the function fails or a process dies. An error that
        skinfield raises on purpose is raised as it is.
    """
    check_count("workers", workers, 1, 4096, "processes at once")
    if workers == 1:
        function = make(*arguments)
        return (function(piece) for piece in pieces)
    return _in_processes(make, arguments, iter(pieces), workers)


def _in_processes(
    make: Callable[..., Callable[[P], R]],
    arguments: tuple[Any, ...],
    pieces: Iterator[P],
    workers: int,
) -> Iterator[R]:
    waiting: deque[tuple[P, Future[R]]] = deque()
    with _pool(workers) as pool:
        for piece in pieces:
            with _one_thread_each():
                waiting.append((piece, _submitted(pool, make, arguments, piece)))
            if len(waiting) >= AHEAD * workers:
                yield _answer(*waiting.popleft())
        while waiting:
            yield _answer(*waiting.popleft())


def _submitted(pool: Any, make: Any, arguments: Any, piece: Any) -> Future[Any]:
    try:
        found: Future[Any] = pool.submit(_call, make, arguments, piece)
    except BrokenProcessPool as error:
        found = Future()
        found.set_exception(error)
    return found


def _call(make: Callable[..., Callable[[P], R]], arguments: tuple[Any, ...], piece: P) -> R:
    """In a process of its own: what is made there stays."""
    if 0 not in _made:
        _made[0] = make(*arguments)
    answer: R = _made[0](piece)
    return answer


def _answer(piece: P, future: Future[R]) -> R:
    try:
        return future.result()
    except SkinfieldError:
        raise
    except BrokenProcessPool as error:
        raise SkinfieldError(
            f"a process died at about piece {piece}, without a word: mostly memory ran out; "
            "take fewer processes"
        ) from error
    except Exception as error:
        raise SkinfieldError(f"piece {piece} failed: {type(error).__name__}: {error}") from error
