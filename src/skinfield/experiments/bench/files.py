"""What was measured as JSON, in the units in which it is read."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from skinfield.errors import FileError
from skinfield.experiments.bench.run import Bench

FORMAT = 1
UNITS = {
    **dict.fromkeys(("seconds", "usual_seconds", "late", "latency", "deadline"), "us"),
    **dict.fromkeys(("place", "place_median"), "mm"),
}
FACTORS = {"us": 1e6, "mm": 1e3}


def bench_as_json(bench: Bench) -> dict[str, Any]:
    """Numbers, texts, lists and objects alone; times in µs and places in mm, as their keys say."""
    return {"format": FORMAT, **_converted(asdict(bench))}


def write_bench(bench: Bench, path: str | Path) -> None:
    """Write a JSON file.

    Raises
    ------
    FileError
        If it cannot be written.
    """
    text = json.dumps(bench_as_json(bench), indent=1, allow_nan=False, ensure_ascii=False)
    try:
        Path(path).write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise FileError(f"{path} cannot be written: {error}; expected a path") from error


def _converted(value: Any) -> Any:
    if isinstance(value, dict):
        return dict(_converted_item(key, each) for key, each in value.items())
    if isinstance(value, list | tuple):
        return [_converted(each) for each in value]
    return value


def _converted_item(key: str, value: Any) -> tuple[str, Any]:
    """A key with its unit, and what it holds in that unit."""
    unit = UNITS.get(key)
    if unit is None:
        return key, _converted(value)
    return f"{key}_{unit}", _scaled(value, FACTORS[unit])


def _scaled(value: Any, factor: float) -> Any:
    """Six digits: more is noise."""
    if isinstance(value, dict):  # a spread
        return {
            name: each if name == "count" else _scaled(each, factor) for name, each in value.items()
        }
    return None if value is None else float(f"{value * factor:.6g}")
