"""Indenters in words: a shape and `key=value` pairs, as on a command line."""

import shlex
from typing import Any

from skinfield.errors import InputError
from skinfield.lab.scenarios.indenters import FACTORS, SHAPES, indenter_from_mapping
from skinfield.simulate import Indenter

WORDS = {"yes": True, "true": True, "no": False, "false": False}


def indenter_from_text(text: str, where: str = "--indenter") -> Indenter:
    """Indenter from its shape and `key=value` words, in mm, N and degrees.

    Keys are those of `indenters`; their units may be left out, so that `radius`
    stands for `radius_mm`.

    Raises
    ------
    InputError
        For words that mean nothing, with those that would.
    FileError
        If the file of a mesh or height map cannot be used.
    """
    return indenter_from_mapping(mapping_from_text(text, where), where)


def mapping_from_text(text: str, where: str = "--indenter") -> dict[str, Any]:
    """Settings that the words stand for."""
    example = SHAPES["sphere"].example
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise InputError(f"{where} is {text!r}: {error}; expected '{example}'") from error
    if not words or "=" in words[0]:
        raise InputError(
            f"{where} is {text!r}, expected a shape first, one of {', '.join(SHAPES)}: "
            f"for example '{example}'"
        )
    mapping: dict[str, Any] = {"shape": words[0]}
    shape = SHAPES.get(words[0])
    for word in words[1:]:
        key, equals, value = word.partition("=")
        if not equals or not value:
            raise InputError(
                f"{where} holds {word!r}, expected key=value: "
                f"for example '{shape.example if shape else example}'"
            )
        key = _full_key(key, shape.keys if shape else ())
        if key in mapping:
            raise InputError(f"{where} gives {key} twice, expected it once")
        mapping[key] = _value(key, value, where)
    return mapping


def _full_key(key: str, known: tuple[str, ...]) -> str:
    """The key with its unit, where it was left out."""
    return next((key + end for end in FACTORS if key + end in known), key)


def _value(key: str, text: str, where: str) -> Any:
    if key == "file":
        return text
    if key == "invert":
        if text.lower() not in WORDS:
            raise InputError(f"{where}: invert is {text!r}, expected yes or no")
        return WORDS[text.lower()]
    try:
        return [float(part) for part in text.split(",")] if key == "down" else float(text)
    except ValueError as error:
        expected = "three numbers such as 0,0,-1" if key == "down" else "a number"
        raise InputError(f"{where}: {key} is {text!r}, expected {expected}") from error
