"""Options of a source, as text with names: read once, and what is left over is refused."""

from collections.abc import Callable, Mapping
from typing import TypeVar

from skinfield.errors import InputError

T = TypeVar("T")
YES, NO = ("yes", "true", "on", "1"), ("no", "false", "off", "0")


class Options:
    """Text by name, of which each is asked for once.

    Parameters
    ----------
    given : mapping of str to str
    whose : str
        Whose options they are, for messages.
    """

    def __init__(self, given: Mapping[str, str], whose: str) -> None:
        self._given, self._whose = dict(given), whose
        self._asked: list[str] = []

    def text(self, name: str, default: str) -> str:
        """As it is."""
        return self._read(name, default, str, "text")

    def whole(self, name: str, default: int) -> int:
        """A whole number; 0x begins a hexadecimal one."""
        return self._read(name, default, lambda text: int(text, 0), "a whole number")

    def number(self, name: str, default: float) -> float:
        """A number, or inf."""
        return self._read(name, default, float, "a number")

    def flag(self, name: str, default: bool) -> bool:
        """Yes or no."""
        return self._read(name, default, _flag, "yes or no")

    def _read(self, name: str, default: T, convert: Callable[[str], T], what: str) -> T:
        self._asked.append(name)
        if name not in self._given:
            return default
        try:
            return convert(self._given[name])
        except ValueError:
            raise InputError(
                f"option {name} of {self._whose} is {self._given[name]!r}, expected {what}"
            ) from None

    def done(self) -> None:
        """Raise InputError if something was given that nobody asked for."""
        for name in self._given:
            if name not in self._asked:
                known = ", ".join(sorted(self._asked)) or "none"
                raise InputError(f"{self._whose} has no option {name!r}, expected one of {known}")


def _flag(text: str) -> bool:
    if text.lower() not in YES + NO:
        raise ValueError(text)
    return text.lower() in YES
