"""`skinfield` within a test: its exit code, what it printed, and where it failed."""

import contextlib
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from skinfield.cli import main


@dataclass(frozen=True)
class Done:
    """A command that has ended."""

    exit_code: int
    stdout: str
    stderr: str

    @property
    def output(self) -> str:
        """All that it printed."""
        return self.stdout + self.stderr


def invoke(words: Sequence[object]) -> Done:
    """Run a command in this process; an error that it did not expect is raised."""
    out, errors, code = io.StringIO(), io.StringIO(), 0
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
        try:
            main([str(word) for word in words])
        except SystemExit as ended:
            code = ended.code if isinstance(ended.code, int) else 1
    return Done(code, out.getvalue(), errors.getvalue())


def run(*words: object) -> str:
    """All that a command printed, which must do what it should."""
    done = invoke(words)
    assert done.exit_code == 0, done.output
    return done.output


def refused(*words: object) -> str:
    """What is said, in one line, by a command that must refuse what it was asked to do."""
    done = invoke(words)
    assert done.exit_code == 2, done.output
    assert "Traceback" not in done.output
    return " ".join(done.output.split())


def result_of(*words: object) -> Any:
    """What a command prints with --json, and nothing else on stdout."""
    done = invoke([*words, "--json"])
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout, parse_constant=AssertionError)
