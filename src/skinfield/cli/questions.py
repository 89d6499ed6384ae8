"""Questions of a command: answered by flags, else in the terminal, else by what is usual."""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from skinfield.cli.report import note
from skinfield.errors import InputError, SkinfieldError, check_positive

T = TypeVar("T")
NONE = "none"  # the word for no answer


@dataclass(frozen=True)
class Questions:
    """Who answers what flags leave open.

    Parameters
    ----------
    yes : bool
        Take what is usual, and ask nothing.
    """

    yes: bool

    @property
    def terminal(self) -> bool:
        """Whether somebody can be asked."""
        return not self.yes and sys.stdin is not None and sys.stdin.isatty()

    def answer(
        self,
        flag: str,
        question: str,
        given: Any,
        usual: str | None,
        read: Callable[[str], T],
        *,
        optional: bool = False,
    ) -> T | None:
        """Value of a flag: as given, as answered, or as usual; None for "none", where allowed.

        Raises
        ------
        InputError
            If it is missing: with the flag that says it.
        """
        if given is not None:
            return self._read(str(given), read, optional)
        if self.terminal:
            return self._prompt(flag, question, usual, read, optional)
        if self.yes and usual is not None:
            return self._read(usual, read, optional)
        hint = "" if usual is None else f", or --yes for {usual!r}"
        raise InputError(f"{flag} is missing, expected an answer to: {question}{hint}")

    def confirm(self, question: str) -> None:
        """Go on only where this is agreed to, in the terminal or by --yes.

        Raises
        ------
        InputError
            If it is not.
        """
        words = ("yes", "no")
        if not self.yes and (
            not self.terminal
            or self.answer("--yes", f"{question} (yes or no)", None, "no", one_of(words)) == "no"
        ):
            raise InputError(f"{question} expected --yes, or another name (-o)")

    def _prompt(
        self, flag: str, question: str, usual: str | None, read: Callable[[str], T], optional: bool
    ) -> T | None:
        shown = "" if usual is None else f" [{usual}]"
        while True:
            sys.stderr.write(f"{question}{shown}: ")
            sys.stderr.flush()
            line = sys.stdin.readline()
            if not line:
                raise InputError(f"{flag} is missing, expected an answer to: {question}")
            text = line.strip() or usual
            if text is None:
                note("an answer is needed, there is no guess; Ctrl-C ends this", "red")
                continue
            try:
                return self._read(text, read, optional)
            except SkinfieldError as error:
                note(str(error), "red")

    @staticmethod
    def _read(text: str, read: Callable[[str], T], optional: bool) -> T | None:
        return None if optional and text == NONE else read(text)


def one_of(words: Sequence[str]) -> Callable[[str], Any]:
    """Reader of one of some words."""

    def read(text: str) -> str:
        if text not in words:
            raise InputError(f"{text!r} is not known, expected one of {', '.join(words)}")
        return text

    return read


def positive(flag: str, why: str) -> Callable[[str], float]:
    """Reader of a number above 0; `why` says what it is."""

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            raise InputError(f"{flag} is {text!r}, expected a number, {why}") from None
        check_positive(flag, value, why)
        return value

    return read
