"""Settings as typed sections, and as TOML and JSON, both ways.

A field's name is its key, and its flag with dashes. Each value is checked when its section is made;
what cannot be used is said with its file, line and key.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, get_args, get_type_hints

from skinfield.errors import FileError, InputError, check_count, check_positive, check_range

T = TypeVar("T")
_WHERE = re.compile(r"(.*?)(?: - at `\$\.?(.*?)`)?", re.DOTALL)
_KINDS = {
    "int": "a whole number", "float": "a number", "str": "a text in quotes",
    "bool": "true or false", "object": "a table", "array": "a list", "null": "nothing",
}  # fmt: skip


class SettingError(InputError):
    """A value of a setting that cannot be used.

    Parameters
    ----------
    name : str
        Of the field.
    text : str
        What is wrong, from the value on.
    """

    def __init__(self, name: str, text: str) -> None:
        super().__init__(f"{name} {text}")
        self.name, self.text = name, text

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.name, self.text)


class Positive(NamedTuple):
    """A finite number above 0."""

    why: str

    def check(self, name: str, value: Any) -> None:
        """Raise InputError unless it is one."""
        check_positive(name, value, self.why)


class Range(NamedTuple):
    """A number, or a whole number, from `low` to `high`."""

    low: float
    high: float
    why: str

    def check(self, name: str, value: Any) -> None:
        """Raise InputError unless it is one."""
        if isinstance(self.low, int) and isinstance(self.high, int):
            check_count(name, value, self.low, self.high, self.why)
        else:
            check_range(name, value, self.low, self.high, self.why)


@cache
def _checks(section: Any) -> tuple[tuple[str, Positive | Range, bool], ...]:
    """Fields with their checks, and whether None is a value too."""
    hints = get_type_hints(section, include_extras=True)
    return tuple(
        (each.name, check, type(None) in get_args(get_args(hints[each.name])[0]))
        for each in fields(section)
        for check in getattr(hints[each.name], "__metadata__", ())
        if isinstance(check, Positive | Range)
    )


@dataclass(frozen=True, kw_only=True)
class Section:
    """Part of the settings; its values are checked as their annotations say."""

    def __post_init__(self) -> None:
        kind: Any = type(self)  # a class, which mypy takes for no Hashable here
        for name, check, may_be_none in _checks(kind):
            value = getattr(self, name)
            if value is None and may_be_none:
                continue
            try:
                check.check(name, value)
            except InputError as error:
                raise SettingError(name, str(error).removeprefix(f"{name} ")) from error
        self.check()

    def check(self) -> None:
        """Raise SettingError where values do not fit each other."""

    def wrong(self, name: str, expected: str) -> SettingError:
        """Error about a value."""
        return SettingError(name, f"is {getattr(self, name)!r}, expected {expected}")


def pair_from_text(name: str, text: str, example: str) -> tuple[str, str]:
    """Key and value of "key=value"."""
    key, equals, value = text.partition("=")
    if not equals or not key:
        raise SettingError(name, f"is {text!r}, expected KEY=VALUE, such as {example}")
    return key, value


def text_of_file(path: str | Path) -> str:
    """Text of a file.

    Raises
    ------
    FileError
        If it cannot be read, or is not UTF-8.
    """
    try:
        return Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error.strerror or error}") from error
    except ValueError as error:  # no UTF-8, or a zero byte in the name
        raise FileError(f"{path} is not text in UTF-8: {error}") from error


def plain_from_toml(text: str, path: str) -> dict[str, Any]:
    """Tables of a TOML text; `path` is what errors call it.

    Raises
    ------
    FileError
        If it is not TOML.
    """
    import tomllib

    try:
        return tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as error:
        raise FileError(f"{path} is not TOML: {error}") from error


def value_from_toml(kind: type[T], text: str, path: str) -> T:
    """Object of a dataclass `kind` of a TOML text; `path` is what errors call it."""
    return value_of_tables(kind, plain_from_toml(text, path), text, path)


def value_of_tables(kind: type[T], tables: object, text: str, path: str, within: str = "") -> T:
    """Object of a dataclass `kind` of tables of a TOML text, or of those `within` one of it."""
    try:
        return from_plain(kind, tables)
    except Misfit as error:
        line = line_of(text, ".".join(filter(None, (within, error.table))), error.key)
        where = f"[{within}] " if within else ""
        raise FileError(f"{path}:{line}: {where}{error}" if line else f"{path}: {error}") from error


def json_from_value(value: Any) -> str:
    """A dataclass as one line of JSON, of which `value_from_json` makes an equal one."""
    import msgspec

    return msgspec.json.encode(value, order="deterministic", enc_hook=str).decode()


def value_from_json(kind: type[T], text: str | bytes) -> T:
    """Undo `json_from_value`.

    Raises
    ------
    InputError
        If it is not JSON, or no such object.
    """
    import msgspec

    try:
        plain = msgspec.json.decode(text)
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise InputError(f"settings are no JSON: {error}") from error
    return from_plain(kind, plain)


class Misfit(InputError):
    """A plain value that cannot be made the object that is wanted.

    Parameters
    ----------
    path : str
        To the value, such as "loop.rate_hz"; empty for all of it.
    text : str
    """

    def __init__(self, path: str, text: str) -> None:
        self.table, _, key = path.rpartition(".")
        self.key = key.partition("[")[0]
        where = f"[{self.table}] " if self.table else ""
        super().__init__(f"{where}{text}")


def from_plain(kind: type[T], plain: object) -> T:
    """Object of a dataclass of dicts, lists, text and numbers, checked key by key.

    Raises
    ------
    InputError
        For a key that there is not, and a value that cannot be used.
    """
    import msgspec

    _check_keys(kind, plain, "")
    try:
        return msgspec.convert(plain, kind, dec_hook=_hook)
    except msgspec.ValidationError as error:
        raise _misfit(kind, plain, error) from error
    except RecursionError as error:
        raise InputError("settings are nested too deeply") from error


def _hook(kind: type, value: Any) -> Any:
    if kind is Path and isinstance(value, str):
        return Path(value)
    raise ValueError(f"is {value!r:.80}, expected a {kind.__name__}")


def _misfit(kind: type, plain: object, error: Exception) -> Misfit:
    """What a library says of a value, as this house says it."""
    found = _WHERE.fullmatch(str(error))
    text, path = (found[1], found[2] or "") if found else (str(error), "")
    cause = error.__cause__
    if cause is not None:  # a check of the object's own, with the name in it
        return Misfit(f"{path}.{getattr(cause, 'name', '')}" if path else "", text)
    expected = re.sub(r"`([^`]*)`", lambda kind: _expected(kind[1]), text.partition(", got")[0])
    expected = expected.removeprefix("Expected ")
    value = _at(plain, path)
    if text.startswith("Object missing"):
        name = text.rpartition(" ")[2].strip("`")
        return Misfit(f"{path}.{name}" if path else name, f"{name} is missing, expected with it")
    if text.startswith("Invalid enum value"):
        words = _words_at(kind, path)
        expected = f"one of {', '.join(words)}{nearest(value, words)}"
    return Misfit(path, f"{path.rpartition('.')[2] or 'it'} is {value!r:.80}, expected {expected}")


def _expected(kinds: str) -> str:
    return " or ".join(_KINDS.get(kind, kind) for kind in kinds.split(" | ") if kind != "null")


def _words_at(kind: Any, path: str) -> list[str]:
    """Words that the field at a path can hold."""
    for part in path.split("."):
        kind = get_type_hints(kind).get(part.partition("[")[0])
    return [str(word) for each in (kind, *get_args(kind)) for word in get_args(each) or ()
            if isinstance(word, str)]  # fmt: skip


def _at(plain: Any, path: str) -> Any:
    for part in re.findall(r"[^.\[\]]+", path):
        try:
            plain = plain[int(part)] if isinstance(plain, list) else plain[part]
        except (KeyError, IndexError, TypeError, ValueError):
            return plain
    return plain


def _check_keys(kind: Any, plain: object, path: str) -> None:
    """Refuse keys that a dataclass and those within it do not have."""
    if not isinstance(plain, Mapping):
        return
    known = {each.name: each for each in fields(kind)}
    for key, value in plain.items():
        here = f"{path}.{key}" if path else str(key)
        if key not in known:
            raise Misfit(
                here,
                f"{key!r} is not known, expected one of {', '.join(known)}{nearest(key, known)}",
            )
        for inner in (known[key].type, *get_args(known[key].type)):
            if isinstance(inner, type) and is_dataclass(inner):
                for each in value if isinstance(value, list) else [value]:
                    _check_keys(inner, each, here)


def nearest(word: object, known: Iterable[str]) -> str:
    """Words that suggest the known name that is nearest, if one is near."""
    close = get_close_matches(word, list(known), n=1) if isinstance(word, str) else []
    return f" (did you mean {close[0]}?)" if close else ""


def line_of(text: str, table: str, key: str) -> int:
    """Line of a key, or of its table's head; 0 where it is written in some other way."""
    name, _, row = table.partition("[")
    wanted, seen, inside = int(row.rstrip("]")) if row else 0, -1, not table
    for number, line in enumerate(text.splitlines(), start=1):
        head = re.match(r"\s*\[\[?\s*([\w.\- ]+?)\s*\]", line)
        if head:
            seen += head[1] == name
            inside = head[1] == name and seen == wanted
            if (inside and not key) or (not table and head[1] == key):
                return number
        elif inside and key:
            before = re.match(r"""\s*["']?([^"'=]*?)["']?\s*=""", line)
            if before and before[1] == key:
                return number
    return 0
