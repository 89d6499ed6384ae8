"""Which key of a scenario's file stands for which field: read and written by the same lists."""

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from skinfield.config.table import Table, number_from_si, quoted
from skinfield.simulate.rig import At, BetweenThree, BetweenTwo, OverTaxels, Places, Random, Raster

T = TypeVar("T")
Keys = Mapping[str, str]  # of the file, to the field

LAYER: Keys = {
    "thickness_mm": "thickness",
    "young_modulus_kpa": "young_modulus",
    "poisson_ratio": "poisson_ratio",
    "relative_permittivity": "relative_permittivity",
}
SOLID: Keys = {"relaxed_fraction": "relaxed_fraction", "time_constant_s": "time_constant"}
PROFILE: Keys = {
    "rest_s": "rest",
    "approach_s": "approach",
    "ramp_s": "ramp",
    "hold_s": "hold",
    "release_s": "release",
    "pause_s": "pause",
    "smooth": "smooth",
    "clearance_mm": "clearance",
}
LOAD_CELL: Keys = {
    "full_scale_n": "full_scale",
    "rate_hz": "rate",
    "noise_mn": "noise",
    "offset_mn": "offset",
    "gain_error": "gain_error",
    "resolution_mn": "resolution",
    "delay_ms": "delay",
}
TEMPERATURE: Keys = {"start_c": "start", "end_c": "end"}
SOLVING: Keys = {"extent_mm": "extent", "cell_mm": "cell", "rungs": "rungs"}
ELECTRONICS: Keys = {
    "quantised": "quantised",
    "gain_spread": "gain_spread",
    "converter_gain_spread": "converter_gain_spread",
    "baseline_spread_counts": "baseline_spread",
}
PARTS: Mapping[str, Keys] = {  # of the electronics
    "cross_talk": {"neighbours": "neighbours"},
    "drift": {
        "mean_counts_per_k": "per_kelvin",
        "converter_spread_counts_per_k": "converter_spread",
        "taxel_spread_counts_per_k": "taxel_spread",
        "time_constant_s": "time_constant",
        "reference_c": "reference",
    },
    "noise": {
        "white_counts": "white",
        "spread": "spread",
        "common_counts": "common",
        "flicker_counts": "flicker",
        "walk_counts_per_sqrt_s": "walk",
    },
    "defects": {
        "absent": "absent",
        "dead": "dead",
        "stuck": "stuck",
        "flickering": "flickering",
        "saturated": "saturated",
        "stuck_within_s": "stuck_within",
        "open_time_s": "open_time",
        "closed_time_s": "closed_time",
    },
    "delivery": {
        "rate_hz": "rate",
        "conversion_time_ms": "conversion_time",
        "free_running": "free_running",
        "delay_ms": "delay",
        "jitter_ms": "jitter",
        "lost_readings": "lost_readings",
        "lost_messages": "lost_messages",
        "holds": "holds",
        "logged_at_hz": "logged_at",
    },
}
CYSKIN: Keys = {"gain_counts": "gain"}
ICUB: Keys = {"rest_capacitance_pf": "rest_capacitance", "step_ff": "farads_per_count"}
ICUB_BYTE: Keys = {"no_load": "no_load", "shift": "shift"}
PLACES: Mapping[str, tuple[Callable[..., Places], Keys]] = {
    "over_taxel": (OverTaxels, {"taxels": "taxels", "angle_deg": "angle"}),
    "between_two": (BetweenTwo, {"pairs": "pairs", "angle_deg": "angle"}),
    "between_three": (BetweenThree, {"triples": "triples", "angle_deg": "angle"}),
    "at": (At, {"positions_mm": "positions", "angle_deg": "angle"}),
    "random": (Random, {"count": "count", "within_mm": "within", "turned": "turned"}),
    "raster": (
        Raster,
        {"rows": "rows", "columns": "columns", "step_mm": "step", "angle_deg": "angle"},
    ),
}
ROWS = {"pairs": 2, "triples": 3, "positions_mm": 2}


def values_of(table: Table, keys: Keys, default: object) -> dict[str, Any]:
    """Fields by name, of a table or else of a default object."""
    return {name: _value(table, key, getattr(default, name)) for key, name in keys.items()}


def _value(table: Table, key: str, default: Any) -> Any:
    if isinstance(default, bool):
        return table.flag(key, default)
    if isinstance(default, int):
        return table.integer(key, default)
    if isinstance(default, tuple):
        if key.endswith("_mm"):
            return table.rows(key, ROWS[key])
        return table.integers(key, ROWS.get(key, 0))
    return table.number(key, float(default))


def lines_of(keys: Keys, source: object) -> list[str]:
    """Lines ``key = value`` of an object's fields."""
    return [f"{key} = {text_of(key, getattr(source, name))}" for key, name in keys.items()]


def text_of(key: str, value: Any) -> str:
    """Value as TOML, in the key's unit."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, tuple | list):
        return "[" + ", ".join(text_of(key, item) for item in value) + "]"
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, int) and not isinstance(value, bool):
        return str(int(value))
    return number_from_si(key, value)
