"""Serialisation of settings: layouts, elastomers, solvers and calibrations as JSON, exactly.

A `ReconstructorConfig` is all that a reconstructor is made of, so that another process, or another
day, makes it again.
"""

import json
import math
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from skinfield.elastic import Layer, Mechanics, Quantity
from skinfield.elastic.observation import on_surface
from skinfield.errors import FileError, InputError
from skinfield.estimate import ContactFinder
from skinfield.reconstruct.reconstructor import Reconstructor
from skinfield.skin import Grid, Patch
from skinfield.solve import Solver

PARTS = "patch", "layer", "mechanics", "quantity", "solver", "noise_std", "finder", "relative"
"""All but the grid, which lies on the patch."""


@lru_cache(maxsize=1)
def _kinds() -> Mapping[str, type]:
    """What a file may name; nothing else is ever made from one."""
    from skinfield.elastic import (
        BaseStress,
        BondedLayer,
        Capacitance,
        CurvedLayer,
        CylindricalBase,
        Gap,
        HalfSpace,
        SphericalBase,
        StandardLinearSolid,
    )
    from skinfield.signal import Calibration, CySkinCount, ICubByte, PlainCount
    from skinfield.solve import (
        Auto,
        ContactFit,
        GaussianField,
        Inverse,
        NonNegative,
        PseudoInverse,
        Tikhonov,
    )

    known = (
        *(Patch, Layer, BondedLayer, HalfSpace, Capacitance, BaseStress, Gap, ContactFinder),
        *(GaussianField, Tikhonov, PseudoInverse, Inverse, NonNegative, ContactFit, Auto),
        *(CurvedLayer, SphericalBase, CylindricalBase),
        *(StandardLinearSolid, Calibration, ICubByte, CySkinCount, PlainCount),
    )
    return {kind.__name__: kind for kind in known}


def plain_from_value(name: str, value: Any) -> Any:
    """A value in what JSON knows; `value_from_plain` makes an equal one of it.

    Parameters
    ----------
    name : str
        Of the value, for messages.
    value : object
        None, a truth, number, text, array, tuple, or one of skinfield's own settings.

    Raises
    ------
    InputError
        For anything else, such as a solver or a function of one's own.
    """
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else {"float": repr(value)}
    if isinstance(value, type) and value in (np.float32, np.float64):
        return {"type": value.__name__}
    if isinstance(value, np.generic):
        return plain_from_value(name, value.item())
    if isinstance(value, np.ndarray) and value.dtype.kind in "fiub":
        values = [plain_from_value(name, item) for item in value.ravel().tolist()]
        return {"array": value.dtype.str, "shape": list(value.shape), "values": values}
    if isinstance(value, tuple):
        return [plain_from_value(f"{name}[{k}]", item) for k, item in enumerate(value)]
    if is_dataclass(value) and _kinds().get(type(value).__name__) is type(value):
        parts = {
            each.name: plain_from_value(f"{name}.{each.name}", getattr(value, each.name))
            for each in fields(value)
            if each.init
        }
        return {"is": type(value).__name__, **parts}
    raise InputError(
        f"{name} is a {type(value).__name__}, which results cannot hold, expected one of "
        f"{', '.join(_kinds())}: a file names only what skinfield itself can make again"
    )


OLDER: dict[str, Any] = {
    "common_mode": 0.0,
    "model_error": 0.0,
    "relaxation": None,
}  # what files mean that do not have these


def value_from_plain(name: str, plain: Any) -> Any:
    """Undo `plain_from_value`; raises FileError for what it never writes."""
    if isinstance(plain, list):
        return tuple(value_from_plain(f"{name}[{k}]", item) for k, item in enumerate(plain))
    if not isinstance(plain, dict):
        return plain
    if "float" in plain:
        return _made(name, float, plain["float"])
    if "type" in plain:
        return {"float32": np.float32, "float64": np.float64}.get(str(plain["type"]))
    if "array" in plain:
        return _made(name, _array, plain)
    kind = _kinds().get(str(plain.get("is")))
    if kind is None:
        raise FileError(
            f"{name} is a {str(plain.get('is'))[:40]!r}, expected one of {', '.join(_kinds())}: "
            "written by a newer skinfield?"
        )
    parts = {key: value_from_plain(f"{name}.{key}", item) for key, item in plain.items()}
    del parts["is"]
    known = {each.name for each in fields(kind) if each.init}
    parts = {key: value for key, value in OLDER.items() if key in known} | parts
    if parts.keys() != known:
        odd = ", ".join(sorted(str(key)[:40] for key in parts.keys() ^ known))
        raise FileError(
            f"{name} is a {kind.__name__} with other settings than this skinfield's ({odd}), "
            "expected the same: open it with the version that wrote it"
        )
    return _made(name, kind, parts)


def _array(plain: Mapping[str, Any]) -> Any:
    if plain["array"][1:] not in ("f8", "f4", "i8", "i4", "u8", "b1"):
        raise ValueError(f"{plain['array']!r} is no type of an array here")
    values = [value_from_plain("values", item) for item in plain["values"]]
    return np.array(values, dtype=plain["array"]).reshape(plain["shape"])


def _made(name: str, make: Any, plain: Any) -> Any:
    """What a maker makes; whatever it raises is the file's fault."""
    try:
        return make(**plain) if isinstance(make, type) and make is not float else make(plain)
    except Exception as error:
        raise FileError(f"{name} cannot be made: {str(error)[:300]}; is the file whole?") from error


@dataclass(frozen=True, eq=False)
class ReconstructorConfig:
    """Arguments of a `Reconstructor`. They can be pickled, and mostly be written as text."""

    patch: Patch
    layer: Layer
    grid: Grid
    mechanics: Mechanics
    quantity: Quantity
    solver: Solver
    noise_std: ArrayLike
    finder: ContactFinder
    relative: bool = False

    @classmethod
    def of(cls, reconstructor: Reconstructor) -> "ReconstructorConfig":
        """Of a reconstructor that is there."""
        return cls(**{each.name: getattr(reconstructor, each.name) for each in fields(cls)})

    def reconstructor(self) -> Reconstructor:
        """Make it: everything that needs no reading is computed now."""
        return Reconstructor(**{each.name: getattr(self, each.name) for each in fields(self)})

    @property
    def without_creep(self) -> "ReconstructorConfig":
        """The same of readings that have been freed from creep, and so have more noise."""
        solid = self.layer.relaxation
        if solid is None:
            return self
        noise = np.asarray(self.noise_std) / solid.relaxed_fraction
        return replace(self, layer=replace(self.layer, relaxation=None), noise_std=noise)

    def to_plain(self) -> dict[str, Any]:
        """In what JSON knows; raises InputError where a part is not skinfield's own."""
        plain = {name: plain_from_value(name, getattr(self, name)) for name in PARTS}
        grid = (self.grid.shape, self.grid.pitch, self.grid.origin)
        return plain | {"grid": plain_from_value("grid", grid)}

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "ReconstructorConfig":
        """Undo `to_plain`; raises FileError for what it never writes."""
        plain = {"relative": True, **plain}  # files that do not say it
        missing = {*PARTS, "grid"} - set(plain)
        if missing:
            raise FileError(f"settings lack {', '.join(sorted(missing))}: is the file whole?")
        if plain.get("intervals") is not None:
            raise FileError(
                "settings have intervals that were learnt from presses, which there are no more, "
                "expected none: reconstruct the recording anew"
            )
        parts = {name: value_from_plain(name, plain[name]) for name in PARTS}
        if not isinstance(parts["patch"], Patch):
            raise FileError(f"patch is a {type(parts['patch']).__name__}, expected a Patch")
        grid = value_from_plain("grid", plain["grid"])
        try:
            shape, pitch, origin = grid
            made = Grid(parts["patch"], shape, pitch, np.asarray(origin))
        except Exception as error:
            raise FileError(f"grid is {str(grid)[:80]}, expected shape, pitch, origin") from error
        grid = on_surface(made, parts["layer"], parts["mechanics"])
        return cls(grid=grid, **parts)


def checksum(plain: Any) -> str:
    """Checksum of what JSON holds, whatever the order of its keys: 8 hexadecimal digits."""
    text = json.dumps(plain, sort_keys=True, separators=(",", ":"))
    return f"{zlib.crc32(text.encode('utf-8', 'surrogatepass')):08x}"


FORMAT, VERSION = "skinfield results", 2
ARRAYS, CONTACTS = "results.zarr", "contacts.parquet"  # in a folder of results


def attributes_from_results(
    config: ReconstructorConfig, notes: tuple[str, ...], source: str
) -> dict[str, Any]:
    """Attributes of a folder of results: what it is, its version, and a checksum of the rest.

    Raises
    ------
    InputError
        If a part of the reconstructor is not skinfield's own.
    """
    content = {"reconstructor": config.to_plain(), "notes": list(notes), "source": source}
    return {"format": FORMAT, "version": VERSION, "check": checksum(content), **content}


def results_from_attributes(
    attributes: Mapping[str, Any], where: str
) -> tuple[ReconstructorConfig, tuple[str, ...], str]:
    """Undo `attributes_from_results`; raises FileError for what it never writes."""
    if attributes.get("format") != FORMAT:
        raise FileError(f"{where} does not say {FORMAT!r} as its format, expected results")
    if attributes.get("version") != VERSION:
        raise FileError(
            f"{where} is of version {str(attributes.get('version'))[:20]}, expected {VERSION}: "
            "open it with the skinfield that wrote it, or reconstruct the recording anew"
        )
    content = {name: attributes.get(name) for name in ("reconstructor", "notes", "source")}
    if attributes.get("check") != checksum(content):
        raise FileError(
            f"{where} is not as it was written (its checksum differs), expected it unchanged: "
            "damaged, or edited; for another solver or grid use open_results(solver=..., grid=...)"
        )
    plain, notes = content["reconstructor"], content["notes"]
    if not isinstance(plain, Mapping) or not isinstance(notes, list):
        raise FileError(f"{where} holds no reconstructor and notes, expected what skinfield writes")
    config = ReconstructorConfig.from_plain(plain)
    return config, tuple(map(str, notes)), str(content["source"])
