"""`skinfield` within a test: its exit code, what it printed, and where it failed."""

import contextlib
import io
from collections.abc import Sequence
from dataclasses import dataclass

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


def invoke(words: Sequence[str]) -> Done:
    """Run a command in this process; an error that it did not expect is raised."""
    out, errors, code = io.StringIO(), io.StringIO(), 0
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
        try:
            main([str(word) for word in words])
        except SystemExit as ended:
            code = ended.code if isinstance(ended.code, int) else 1
    return Done(code, out.getvalue(), errors.getvalue())
