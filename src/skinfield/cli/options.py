"""Options that commands share, and the objects that they stand for: the only list of variants."""

import importlib
import inspect
import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Group, Parameter

from skinfield.cli.report import say_profile
from skinfield.errors import InputError
from skinfield.settings import Elastomer, ModelSettings, Profile, profile_of
from skinfield.settings.tree import Positive, Range, Section

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from skinfield.elastic import Layer, Mechanics, Quantity
    from skinfield.reconstruct import Reconstructor
    from skinfield.reconstruct.diagnostics import Conditioning
    from skinfield.skin import Patch, Skin
    from skinfield.solve import Solver

SOLVERS = {
    "gaussian": "GaussianField",
    "contact": "ContactFit",
    "nonnegative": "NonNegative",
    "tikhonov": "Tikhonov",
    "pseudo-inverse": "PseudoInverse",
    "inverse": "Inverse",
}
FLAGS = {  # of fields whose flag has another name
    "layout": "skin",
    "options": "set",
    "as_json": "json",
    "into": "record",
}
OF_UNIT = {"count": "capacitance", "dC/C0": "capacitance", "Pa": "stress", "1": "gap"}
USUAL_SOLVER = "gaussian"
USUAL_NO_LOAD = 240  # of an iCub byte
PER_PITCH, COARSEST, FINEST = 4, 10, 80  # nodes: to a pitch of the taxels, at least, at most

Json = Annotated[bool, Parameter(negative=())]
Force = Annotated[bool, Parameter(negative=(), help="Write over a file that is there.")]
LAYOUT = Parameter(name="LAYOUT")
OUTPUT = Parameter(name=["--output", "-o"])


def part(title: str) -> Parameter:
    """A section of settings as flags under this heading."""
    return Parameter(name="*", group=Group(title, sort_key=_place()))


_places = iter(range(1, 1000))


def _place() -> int:
    """Headings stand in the order of the program."""
    return next(_places)


@dataclass(frozen=True, kw_only=True)
class CountSettings(Section):
    """What the counts of a recording mean.

    Parameters
    ----------
    board : str
        Whose counts they are; auto goes by their range.
    no_load : int, optional
        What an iCub byte rests at. Default the profile's, else 240.
    gain : float, optional
        Counts per unit of ΔC/C₀; negative where pressure lowers them. Default the profile's.
    calibration : str, optional
        Calibration file (.toml, .npz) instead of both.
    smoothing_ms : float, ms
        Time constant of an exponential filter, ms; 0: none.
    noise : float, optional
        Standard deviation of a reading, in the quantity's unit.
    """

    board: Literal["auto", "icub", "cyskin"] = "auto"
    no_load: Annotated[int | None, Range(1, 255, "what an iCub byte rests at")] = None
    gain: float | None = None
    calibration: str | None = None
    smoothing_ms: Annotated[float, Range(0.0, 1e6, "ms; 0: none")] = 0.0
    noise: Annotated[float | None, Positive("no reading is exact")] = None


def solver_of(name: str) -> "Solver":
    """Solver of a name in `SOLVERS`, as it usually is."""
    from skinfield import solve as inverse

    solver: Solver = getattr(inverse, SOLVERS[name])()
    return solver


def mechanics_of(name: str) -> "Mechanics":
    """Model of the elastomer, by its name on the command line."""
    from skinfield.elastic import BondedLayer, HalfSpace

    return (
        HalfSpace()
        if name == "half-space"
        else BondedLayer(inextensible_cover=name == "covered-layer")
    )


def quantity_of(name: str) -> "Quantity":
    """What a taxel reads, by its name on the command line."""
    from skinfield.elastic import BaseStress, Capacitance, Gap, Quantity

    kinds: dict[str, type[Quantity]] = {
        "capacitance": Capacitance,
        "gap": Gap,
        "stress": BaseStress,
    }
    return kinds[name]()


def skin_from_text(text: str) -> "Skin":
    """Skin of a layout file, or a generator by name."""
    from skinfield.files.layouts.load import skin_from_text as skin_of_words

    return skin_of_words(text)


def profile_in_use(given: Elastomer, hardware: str | None = None, layout: str = "") -> Profile:
    """Profile of whose skin it is, which is named on stderr."""
    profile = profile_of(given, hardware, layout)
    say_profile(profile.sentence(given))
    return profile


def layer_of(given: Elastomer, profile: Profile) -> "Layer":
    """Elastomer, in SI units: what was given, else the profile's."""
    from skinfield.elastic import Layer

    thickness, modulus, poisson = (
        getattr(profile if getattr(given, name) is None else given, name)
        for name in ("thickness_mm", "modulus_kpa", "poisson")
    )
    return Layer(thickness * 1e-3, modulus * 1e3, poisson)


def nodes_for(patch: "Patch", most: int = FINEST) -> int:
    """Nodes on a side of the grid: four to a taxel's pitch, over the patch's longer side."""
    import numpy as np

    from skinfield.skin.geometry import nearest_distance

    pitch = float(np.median(nearest_distance(patch.positions)))
    extent = float(np.ptp(patch.plane, axis=0).max())
    if not 0.0 < pitch < np.inf:
        return COARSEST
    return int(np.clip(np.ceil(PER_PITCH * extent / pitch), COARSEST, most))


def reconstructor_of(
    patch: "Patch",
    layer: "Layer",
    quantity: "Quantity",
    noise_std: "ArrayLike",
    model: ModelSettings,
    profile: Profile,
) -> "Reconstructor":
    """Reconstruction with the chosen grid, mechanics and solver."""
    from skinfield.reconstruct import Reconstructor
    from skinfield.skin import Grid

    return Reconstructor(
        patch,
        layer,
        Grid.square(patch, nodes=model.grid or nodes_for(patch)),
        mechanics=mechanics_of(model.mechanics or profile.mechanics),
        quantity=quantity,
        solver=solver_of(model.solver or USUAL_SOLVER),
        noise_std=noise_std,
    )


def conditioning_of(
    patch: "Patch", given: CountSettings, profile: Profile | None = None
) -> "Conditioning":
    """What counts mean."""
    from skinfield.reconstruct.diagnostics import Conditioning
    from skinfield.signal import (
        Convention,
        CySkinCount,
        Exponential,
        Filter,
        ICubByte,
        NoFilter,
        load_calibration,
    )

    known = profile or CountSettings()  # gain and rest, where they were not given
    no_load = given.no_load or known.no_load or USUAL_NO_LOAD
    conventions: dict[str, Convention | None] = {
        "auto": None if no_load == USUAL_NO_LOAD else ICubByte(no_load=no_load),
        "icub": ICubByte(no_load=no_load),
        "cyskin": CySkinCount(),
    }
    seconds, path = given.smoothing_ms * 1e-3, given.calibration
    smooth: Filter = Exponential(time_constant=seconds) if seconds else NoFilter()
    return Conditioning(
        board=conventions[given.board],
        gain=known.gain if given.gain is None else given.gain,
        calibration=None if path is None else load_calibration(path, patch),
        filter=smooth,
        noise_std=given.noise,
    )


def flag_of(name: str) -> str:
    """Flag of a field or parameter, without its dashes."""
    return FLAGS.get(name, name.strip("_").replace("_", "-").lower())


def flags_given(command: Callable[..., Any], values: dict[str, Any]) -> list[tuple[str, str]]:
    """Names and flags of the parameters of a command that are not as usual, in its order."""
    names: list[str] = []
    for parameter in inspect.signature(command).parameters.values():
        value = values[parameter.name]
        if is_dataclass(value):
            more = fields(value)
            names += [each.name for each in more if getattr(value, each.name) != each.default]
        elif value != parameter.default and parameter.kind is parameter.KEYWORD_ONLY:
            names.append(parameter.name)
    return [(name, f"--{flag_of(name)}") for name in names]


def patch_of(skin: "Skin", name: str | None) -> "Patch":
    """The patch that is meant: the only one, or the one of this name or number (from 0)."""
    if name is not None:
        return skin[int(name)] if name.isdecimal() else skin[name]
    if len(skin) > 1:
        raise InputError(
            f"{skin.name} has {len(skin)} patches, expected one: choose with --patch from "
            f"{', '.join(patch.name for patch in skin)}"
        )
    return skin[0]


def solver_from_text(text: str, settings: str = "{}") -> "Solver":
    """Solver by its name on the command line, or by where it is imported from.

    Parameters
    ----------
    text : str
        Such as "gaussian" or "package.module:Class"; a class, or a function that makes a
        solver, is called with the settings.
    settings : str
        A JSON object.

    Raises
    ------
    InputError
        If there is no such solver, it does not take these settings, or it has no `prepare`.
    """
    given = _settings(settings)
    if ":" in text:
        make = _imported(text)
    elif text in SOLVERS:
        from skinfield import solve as inverse

        make = getattr(inverse, SOLVERS[text])
    else:
        raise InputError(
            f"--solver is {text!r}, expected one of {', '.join(SOLVERS)}, or your own as "
            "package.module:Class"
        )
    try:
        ready = (_is_solver(make) and not given) or not callable(make)
        solver = make if ready else make(**given)
    except TypeError as error:
        raise InputError(f"--settings is {settings}, but {text} says: {error}") from error
    if not _is_solver(solver):
        raise InputError(
            f"--solver is {text!r}, which has no prepare(model), expected a solver: "
            "see CONTRIBUTING.md"
        )
    return solver  # type: ignore[no-any-return]


def _is_solver(found: Any) -> bool:
    """Whether it is an object, not a class of objects, that prepares."""
    return not isinstance(found, type) and callable(getattr(found, "prepare", None))


def _settings(text: str) -> dict[str, Any]:
    try:
        found = json.loads(text)
    except ValueError as error:
        raise InputError(f"--settings is {text!r}, expected a JSON object: {error}") from error
    if not isinstance(found, dict):
        raise InputError(f"--settings is {text!r}, expected a JSON object such as {{}}")
    return found


def _imported(text: str) -> Any:
    module, _, attribute = text.partition(":")
    with _current_folder():
        try:
            found = importlib.import_module(module)
        except Exception as error:  # whatever runs while a foreign module is imported
            raise InputError(
                f"--solver is {text!r}, but {module!r} cannot be imported: "
                f"{type(error).__name__}: {error}"
            ) from error
    if not hasattr(found, attribute):
        raise InputError(f"--solver is {text!r}, but {module} has no {attribute!r}")
    return getattr(found, attribute)


@contextmanager
def _current_folder() -> Iterator[None]:
    """Modules of the current folder can be imported, as with `python -m`."""
    here = str(Path.cwd())
    sys.path.insert(0, here)
    try:
        yield
    finally:
        sys.path.remove(here)
