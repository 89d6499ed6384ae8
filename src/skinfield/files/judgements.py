"""Maps of a judged layout as CSV, and all of it as JSON."""

from pathlib import Path
from typing import Any

import numpy as np

from skinfield.design import Judgement, Places
from skinfield.errors import Floats, InputError
from skinfield.files.pending import write_bytes
from skinfield.files.summary import write_summary

ENDINGS = {".csv": "a table, one row per place", ".json": "all maps with what they were made for"}


def check_judgement_name(path: str | Path) -> Path:
    """Raise InputError unless `path` ends in .csv or .json."""
    path = Path(path)
    if path.suffix.lower() not in ENDINGS:
        known = ", ".join(f"{ending} ({what})" for ending, what in ENDINGS.items())
        raise InputError(f"{str(path)!r} ends in {path.suffix!r}, expected one of {known}")
    return path


def save_judgement(judgement: Judgement, path: str | Path) -> Path:
    """Write the maps of a layout.

    A .csv holds one row per place: the plane's coordinates and every map, in mm and N; the two
    touches, judged at fewer places, have those of the nearest place. Infinite is `inf`. A .json
    holds every map at its own places, with terms, numbers and verdict; infinite is null.

    Raises
    ------
    InputError
        If the extension is another one.
    FileError
        If the file cannot be written.
    """
    path = check_judgement_name(path)
    if path.suffix.lower() == ".json":
        write_summary(path, _mapping(judgement))
    else:
        write_bytes(path, _table(judgement).encode())
    return path


def _table(judgement: Judgement) -> str:
    places = judgement.blind.places
    columns = {"x_mm": places.plane[:, 0] * 1e3, "y_mm": places.plane[:, 1] * 1e3}
    columns["response_share"] = judgement.blind.response
    for name, unit, where, values in judgement.maps():
        columns[_column(name, unit)] = _at(places, where, values)
    rows = [",".join(columns)]
    rows += [
        ",".join(f"{value:.6g}" for value in row) for row in zip(*columns.values(), strict=True)
    ]
    return "\n".join(rows) + "\n"


def _column(name: str, unit: str) -> str:
    return f"{name.replace(', ', '_').replace(' ', '_')}_{unit}"


def _at(places: Places, where: Places, values: Floats) -> Floats:
    """Values of other places, each that of the nearest."""
    from scipy.spatial import cKDTree

    if where is places:
        return values
    return np.asarray(values[cKDTree(where.plane).query(places.plane)[1]])


def _mapping(judgement: Judgement) -> dict[str, Any]:
    design, blind = judgement.design, judgement.blind
    maps = [
        {"name": name, "unit": unit, "x_mm": p.plane[:, 0] * 1e3, "y_mm": p.plane[:, 1] * 1e3,
         "values": values}
        for name, unit, p, values in judgement.maps()
    ]  # fmt: skip
    holes = [
        {"area_mm2": hole.area * 1e6, "middle_mm": hole.middle * 1e3, "response": hole.deepest}
        for hole in blind.holes
    ]
    return {
        "patch": design.patch.name,
        "taxels": len(design.patch),
        "thickness_mm": design.layer.thickness * 1e3,
        "modulus_kpa": design.layer.young_modulus / 1e3,
        "poisson": design.layer.poisson_ratio,
        "quantity": design.quantity.symbol,
        "noise": design.noise,
        "force_n": judgement.touch.force,
        "radius_mm": judgement.touch.radius * 1e3,
        "terms": vars(judgement.terms),
        "verdict": judgement.verdict(),
        "blind_share": blind.blind_share,
        "missed_share": judgement.missed_share,
        "independent_places": judgement.detectable.searched.independent(
            judgement.detectable.false_alarm_rate
        ),
        "numbers": [vars(row) for row in judgement.rows()],
        "response_share": blind.response,
        "holes": holes,
        "maps": maps,
    }
