"""Pieces in processes: in order, one thread each, errors said, Ctrl-C clean."""

import os
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable

import pytest

from skinfield.campaign.ordered import in_order
from skinfield.errors import InputError, SkinfieldError


def made(offset: int) -> Callable[[int], tuple[int, int, str]]:
    calls = []

    def function(piece: int) -> tuple[int, int, str]:
        calls.append(piece)
        if piece == 13:
            raise InputError("13 is no piece")
        if piece == 14:
            raise ValueError("what is this")
        if piece == 15:
            os._exit(1)
        time.sleep(0.02 * (piece % 3 == 0))  # so that they end in another order
        return piece + offset, len(calls), os.environ.get("OPENBLAS_NUM_THREADS", "")

    return function


@pytest.mark.parametrize("workers", [1, 2])
def test_answers_come_in_order_and_each_process_prepares_once(workers: int) -> None:
    found = list(in_order(made, (100,), range(12), workers))
    assert [answer for answer, _, _ in found] == list(range(100, 112))
    assert max(calls for _, calls, _ in found) >= 12 // workers
    if workers > 1:
        assert {threads for _, _, threads in found} == {"1"}


def test_pieces_are_taken_as_they_are_needed() -> None:
    taken = []

    def pieces():
        for piece in range(12):
            taken.append(piece)
            yield piece

    answers = in_order(made, (0,), pieces(), 2)
    assert next(answers)[0] == 0
    assert len(taken) <= 5
    answers.close()


@pytest.mark.parametrize(
    ("piece", "kind", "said"),
    [
        (13, InputError, "^13 is no piece$"),
        (14, SkinfieldError, "piece 14 failed: ValueError: what is this"),
        (15, SkinfieldError, "a process died at about piece"),
    ],
)
def test_what_goes_wrong_is_said(piece: int, kind: type[Exception], said: str) -> None:
    with pytest.raises(kind, match=said):
        list(in_order(made, (0,), [1, piece, 2], 2))
    with pytest.raises(InputError, match="workers is 0"):
        in_order(made, (0,), [1], 0)


def test_ctrl_c_ends_all_processes(tmp_path) -> None:
    (tmp_path / "slow.py").write_text(
        textwrap.dedent("""
        import os, time
        def make():
            def function(piece):
                time.sleep(0.05)
                return os.getpid()
            return function
    """)
    )
    (tmp_path / "main.py").write_text(
        textwrap.dedent("""
        import signal
        from skinfield.campaign.ordered import in_order
        from slow import make
        if __name__ == "__main__":
            signal.signal(signal.SIGINT, signal.default_int_handler)  # a job may begin without
            try:
                for answer in in_order(make, (), range(10000), 2):
                    print(answer, flush=True)
            except KeyboardInterrupt:
                print("stopped", flush=True)
    """)
    )
    running = subprocess.Popen(
        [sys.executable, str(tmp_path / "main.py")], stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True, cwd=tmp_path, start_new_session=True,
    )  # fmt: skip
    assert running.stdout is not None
    pids = {int(running.stdout.readline()) for _ in range(6)}
    os.killpg(running.pid, signal.SIGINT)  # as a terminal does: all processes get it
    out, err = running.communicate(timeout=60)
    assert out.splitlines()[-1] == "stopped"
    assert "Traceback" not in err
    for pid in pids:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)
