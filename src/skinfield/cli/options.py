"""Options that commands share, and the objects that they stand for: the only list of variants."""

import inspect
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields, is_dataclass, replace
from math import ceil, inf
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, get_type_hints

from cyclopts import Group, Parameter

import skinfield as sf
from skinfield.cli.profiles import SkinProfile, profile_of
from skinfield.cli.report import note
from skinfield.cli.settings import (
    Elastomer,
    ModelSettings,
    QuantityName,
    Settings,
    SkinSettings,
    SolverName,
    TaxelSettings,
    load_settings,
    taxels_of,
)
from skinfield.errors import FileError, InputError
from skinfield.page.settings import PageSettings
from skinfield.processes import processors
from skinfield.settings import Positive, Range, Section, from_plain, text_of_file
from skinfield.skin.log import BoardName, LogSettings

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from skinfield.calibrate import TouchCalibration
    from skinfield.reconstruct.diagnostics import Conditioning
    from skinfield.reconstruct.serialisation import ReconstructorConfig
    from skinfield.signal import Calibration

    KnownQuantity = sf.BaseStress | sf.Capacitance | sf.Gap

SOLVERS = {
    "auto": "Auto",
    "gaussian": "GaussianField",
    "contact": "ContactFit",
    "nonnegative": "NonNegative",
    "tikhonov": "Tikhonov",
    "pseudo-inverse": "PseudoInverse",
    "inverse": "Inverse",
}
FLAGS = {  # of fields whose flag has another name
    "layout": "skin",
    "urdf": "robot",
    "robot": "robot-name",
    "options": "set",
    "as_json": "json",
    "into": "record",
    "channels": "channel",
    "rate": "rate-hz",
    "lead_in": "lead-in-s",
}
OF_UNIT = {"count": "capacitance", "dC/C0": "capacitance", "Pa": "stress", "1": "gap"}
S = TypeVar("S", bound=Section)
E = TypeVar("E", bound=Elastomer)
T = TypeVar("T")
QUANTITIES = {"capacitance": "Capacitance", "gap": "Gap", "stress": "BaseStress"}
LIVE = ".mcap"  # ends the name of a recording of a live skin
USUAL_SOLVER: SolverName = "auto"
USUAL_NO_LOAD = 240  # of an iCub byte
PER_PITCH, COARSEST, FINEST = 4, 10, 80  # nodes: to a pitch of the taxels, at least, at most

_places = iter(range(1, 1000))


def part(title: str) -> Parameter:
    """A section of settings as flags under this heading."""
    return heading(title, name="*")


def heading(title: str, name: str | None = None) -> Parameter:
    """Heading in the help for a flag; headings stand in the program's order."""
    return Parameter(name=name, group=Group(title, sort_key=next(_places)))


@dataclass(frozen=True, kw_only=True)
class CountSettings(TaxelSettings):
    """What the counts of a recording mean; see also `TaxelSettings`.

    Parameters
    ----------
    board : str
        Whose counts they are; auto goes by their range, plain ones rest where each taxel does and
        rise when pressed, plain-falling ones fall.
    smoothing_ms : float, ms
        Time constant of an exponential filter, ms; 0: none.
    noise : float, optional
        Standard deviation of a reading, in the quantity's unit.
    tare : str, optional
        FROM,TO: when nothing touched, s after the first reading; taxels rest at what they read
        then. Default the quietest stretch.
    """

    board: BoardName = "auto"
    smoothing_ms: Annotated[float, Range(0.0, 1e6, "ms; 0: none")] = 0.0
    noise: Annotated[float | None, Positive("no reading is exact")] = None
    tare: str | None = None

    def check(self) -> None:
        """See `Section`."""
        super().check()
        if self.tare is not None:
            times_of("--tare", self.tare)


Counts = Annotated[CountSettings, part("Counts")]
OfElastomer = Annotated[Elastomer, part("Elastomer")]
Model = Annotated[ModelSettings, part("Model")]
Page = Annotated[PageSettings, part("Page")]

# Parameters of several commands: `--help` has their help, `check_values` checks what they allow.
OUTPUT = Parameter(name=["--output", "-o"])
Json = Annotated[bool, Parameter(negative=(), help="The result as one JSON object.")]
Force = Annotated[bool, Parameter(negative=(), help="Write over a file that is there.")]
LayoutText = Annotated[str, Parameter(help="Layout file, or a generator by name.")]
LayoutWord = Annotated[LayoutText, Parameter(name="LAYOUT")]
PatchName = Annotated[
    str | None, Parameter(help="Name or number of the patch of a layout with several.")
]
Reads = Annotated[QuantityName, Parameter(help="What a taxel reads.")]
Noise = Annotated[
    float | None,
    Positive("no reading is exact"),
    Parameter(help="Of a reading, in the quantity's unit. Default typical."),
]
Seed = Annotated[int, Range(0, 1 << 63, "of what is random"), Parameter(help="Of what is random.")]
Workers = Annotated[
    int | None,
    Range(1, 1 << 12, "processes at once"),
    Parameter(help="Processes at once. Default one for each core."),
]
Duration = Annotated[
    float | None, Positive("seconds"), Parameter(help="Seconds; default until Ctrl-C.")
]
McapFile = Annotated[str, Parameter(name="FILE", help="Recording (.mcap).")]
LiveName = Annotated[str | None, Parameter(name="NAME", help="Of the running skin.")]


def check_values(command: Callable[..., Any], values: Mapping[str, Any]) -> None:
    """Raise InputError, with the flag, where a value is not as its parameter's annotation says."""
    for name, hint in get_type_hints(command, include_extras=True).items():
        value = values.get(name)
        for check in getattr(hint, "__metadata__", ()):
            if isinstance(check, Positive | Range):
                for each in value if isinstance(value, tuple) else (value,):
                    if each is not None:
                        check.check(f"--{flag_of(name)}", each)


def parsed(flag: str, text: str, read: Callable[[str], T]) -> T:
    """What the text of a flag means; errors name the flag."""
    try:
        return read(text)
    except InputError as error:
        raise InputError(f"{flag} is {text!r}: {error}") from error


def solver_of(name: str) -> Any:
    """Solver of a name in `SOLVERS`, as it usually is."""
    return getattr(sf, SOLVERS[name])()


def mechanics_of(name: str) -> "sf.BondedLayer | sf.HalfSpace":
    """Model of the elastomer, by its name on the command line."""
    if name == "half-space":
        return sf.HalfSpace()
    return sf.BondedLayer(inextensible_cover=name == "covered-layer")


def quantity_of(name: str) -> "KnownQuantity":
    """What a taxel reads, by its name on the command line."""
    quantity: KnownQuantity = getattr(sf, QUANTITIES[name])()
    return quantity


def skin_from_text(text: str) -> "sf.Skin":
    """Skin of a layout file, of a recording that has it enclosed, or a generator by name."""
    if text.lower().endswith(LIVE):
        from skinfield.files.mcap.live import LiveRecording

        return LiveRecording.open(Path(text)).skin
    from skinfield.files.layouts.load import skin_from_text as skin_of_words

    return skin_of_words(text)


def skin_of(section: SkinSettings) -> "sf.Skin":
    """Skin of the settings of one, on its robot where they name it."""
    if section.urdf is None:
        return skin_from_text(section.layouts[0])
    parts = section.parts()
    everywhere = parts.pop("", [])
    if parts and everywhere:
        raise InputError(
            f"--skin is {everywhere[0]!r} beside {', '.join(parts)}, expected LINK=LAYOUT for each"
        )
    return sf.load_robot(section.urdf, skin=parts or everywhere).skin


@contextmanager
def layout_text(section: SkinSettings) -> Iterator[str]:
    """What another process reads the skin from: the layout, or a file of all that is on a robot."""
    if section.urdf is None:
        yield section.layouts[0]
        return
    with TemporaryDirectory() as folder:
        path = Path(folder) / "skin.npz"
        sf.save_layout(skin_of(section), path)
        yield str(path)


def profile_in_use(wanted: Elastomer, hardware: str | None = None, layout: str = "") -> SkinProfile:
    """Profile of whose skin it is, which is named on stderr."""
    from skinfield.files.layouts.load import layout_format

    profile = profile_of(wanted, hardware, layout_format(layout))
    note(profile.sentence(wanted))
    return profile


def filled(section: S, profile: SkinProfile) -> S:
    """Section of settings in which the profile's values stand for those that were left out."""
    missing = [each.name for each in fields(section) if getattr(section, each.name) is None]
    known = {name: getattr(profile, name) for name in missing if hasattr(profile, name)}
    return replace(section, **known)


def layer_of(elastomer: Elastomer, profile: SkinProfile | None = None) -> "sf.Layer":
    """Elastomer, in SI units: what was set, else the profile's."""
    whole = asdict(elastomer if profile is None else filled(elastomer, profile))
    creep, seconds = whole["relaxed_fraction"], whole["relaxation_s"]
    return sf.Layer(
        whole["thickness_mm"] * 1e-3,
        whole["modulus_kpa"] * 1e3,
        whole["poisson"],
        relaxation=None if creep is None else sf.StandardLinearSolid(creep, seconds),
    )


def nodes_for(patch: "sf.Patch", most: int = FINEST) -> int:
    """Nodes on a side of the grid: four to a taxel's pitch, over the patch's longer side."""
    extent = float((patch.plane.max(axis=0) - patch.plane.min(axis=0)).max())
    return min(max(ceil(PER_PITCH * extent / patch.pitch), COARSEST), most)


def config_of(
    patch: "sf.Patch",
    layer: "sf.Layer",
    quantity: "KnownQuantity",
    noise_std: "ArrayLike",
    model: ModelSettings,
    relative: bool = False,
) -> "ReconstructorConfig":
    """Reconstruction with the chosen grid, mechanics and solver; relative if no scale is known."""
    from skinfield.reconstruct.serialisation import ReconstructorConfig

    return ReconstructorConfig(
        patch,
        layer,
        sf.Grid.square(patch, nodes=model.grid or nodes_for(patch)),
        mechanics_of(model.mechanics or "layer"),
        quantity,
        solver_of(model.solver or USUAL_SOLVER),
        noise_std,
        sf.ContactFinder(),
        relative,
    )


def conditioning_of(patch: "sf.Patch", counts: CountSettings) -> "Conditioning":
    """What counts mean; gain and rest that are not set are the board's."""
    from skinfield.reconstruct.diagnostics import Conditioning
    from skinfield.signal import (
        Convention,
        CySkinCount,
        Exponential,
        ICubByte,
        NoFilter,
        PlainCount,
    )

    no_load = counts.no_load or USUAL_NO_LOAD
    icub = ICubByte(no_load=no_load)
    conventions: dict[str, Convention | None] = {
        "auto": None if no_load == USUAL_NO_LOAD else icub, "icub": icub, "cyskin": CySkinCount(),
        "plain": PlainCount(), "plain-falling": PlainCount(falls=True),
    }  # fmt: skip
    seconds, path = counts.smoothing_ms * 1e-3, counts.calibration
    return Conditioning(
        board=conventions[counts.board],
        gain=counts.gain,
        calibration=None if path is None else calibration_in(path, patch),
        filter=Exponential(time_constant=seconds) if seconds else NoFilter(),
        noise_std=counts.noise,
        tare=None if counts.tare is None else times_of("--tare", counts.tare),
        keep=taxels_of("--keep", counts.keep, len(patch)),
        without=taxels_of("--without", counts.without, len(patch)),
    )


def times_of(flag: str, text: str) -> tuple[float, float]:
    """Two times, s, such as 0,6.5; InputError for what is none."""
    try:
        begin, end = map(float, text.split(","))
    except ValueError:
        begin, end = 0.0, -1.0
    if not 0.0 <= begin < end < inf:
        raise InputError(f"{flag} is {text!r}, expected two numbers such as 0,6.5, in s")
    return begin, end


def check_calibration(path: str) -> None:
    """Raise InputError unless the file of a calibration is there."""
    if not Path(path).is_file():
        raise InputError(
            f"--calibration is {path!r}, which is not there, expected a calibration (.toml, .npz)"
        )


def calibration_in(path: str, patch: "sf.Patch") -> "Calibration | None":
    """Calibration of a file, or the one that a recording of a live skin has enclosed, if any."""
    if path.lower().endswith(LIVE):
        from skinfield.files.mcap.live import LiveRecording

        return LiveRecording.open(Path(path)).calibrations.get(patch.name)
    from skinfield.calibrate import TouchCalibration, load_calibration
    from skinfield.signal import Calibration

    check_calibration(path)
    made = load_calibration(path, patch)
    known = made.of_taxels(patch) if isinstance(made, TouchCalibration) else made
    if not isinstance(known, Calibration):
        raise InputError(
            f"--calibration is {path!r}, which holds a {type(made).__name__}, expected one of "
            "counts or by touches, which know each taxel by itself; `skinfield calibrate check` "
            "answers by this one"
        )
    return known


def calibration_for(path: str | None, skin: "sf.Skin") -> dict[str, "Calibration"]:
    """Calibration of a file by the name of the patch that it is of, for a live skin."""
    made: dict[str, Calibration | None] = {}
    for patch in skin if path is not None else ():
        try:
            made[patch.name] = calibration_in(str(path), patch)
        except FileError:
            if patch is skin[-1] and not made:  # else it is of another patch
                raise
    found = {name: its for name, its in made.items() if its is not None}
    if path is not None and len(found) != 1 and not path.lower().endswith(LIVE):
        raise InputError(
            f"--calibration is {path!r}, which fits {', '.join(found)}, expected one patch of "
            f"{skin.name}: make it of a recording in counts, whose taxels are known"
        )
    return found


def touched_skin(path: str | None) -> "TouchCalibration | None":
    """Calibration by touches of a file, which knows the layer, if it is one."""
    if path is None or path.lower().endswith(LIVE):
        return None
    from skinfield.calibrate import TouchCalibration, load_calibration

    made = load_calibration(path)
    return made if isinstance(made, TouchCalibration) else None


def by_touch(
    path: str | None, elastomer: E, model: ModelSettings
) -> tuple[E, ModelSettings, "TouchCalibration | None"]:
    """What a calibration by touches knows, if it is one, for what is not set; and itself."""
    skin = touched_skin(path)
    if skin is None:
        return elastomer, model, None
    note(skin.verdict)
    return *by_model(skin.layer, skin.mechanics, elastomer, model), skin


def by_model(
    layer: "sf.Layer", mechanics: object, elastomer: E, model: ModelSettings
) -> tuple[E, ModelSettings]:
    """Layer and cover for what is not set."""
    found = {
        "thickness_mm": layer.thickness * 1e3,
        "modulus_kpa": layer.young_modulus * 1e-3,
        "poisson": layer.poisson_ratio,
    }
    if layer.relaxation is not None and elastomer.relaxed_fraction is None:
        solid = layer.relaxation
        found |= {"relaxed_fraction": solid.relaxed_fraction, "relaxation_s": solid.time_constant}
    missing = {name: its for name, its in found.items() if getattr(elastomer, name) is None}
    if model.mechanics is None and getattr(mechanics, "inextensible_cover", False):
        model = replace(model, mechanics="covered-layer")
    return replace(elastomer, **missing), model  # type: ignore[arg-type]


def assumed_of(
    counts: TaxelSettings, elastomer: Elastomer, skin: "TouchCalibration | None"
) -> tuple[str, ...]:
    """What of the scale of forces, "gain" and "modulus", nothing known gives."""
    gain = counts.gain is None and counts.calibration is None
    modulus = skin.relative if skin else elastomer.modulus_kpa is None
    return ("gain",) * gain + ("modulus",) * modulus


def is_relative(assumed: tuple[str, ...], unit: str) -> bool:
    """Whether forces hold up to one factor, where this is assumed and readings have such a unit."""
    if unit == "Pa":  # the base bears the force, whatever its modulus
        return False
    return bool(set(assumed) - ({"gain"} if unit != "count" else set()))


def settings_in(path: str) -> Settings | None:
    """Settings that a recording of a live skin was made with; None if it does not say."""
    from skinfield.files.mcap.live import LiveRecording

    plain = LiveRecording.open(Path(path)).description.get("settings")
    return None if plain is None else from_plain(Settings, plain)


def own_settings(layout: str) -> tuple[Settings, LogSettings] | None:
    """Settings in a skin's file, and how its logs are read; None of any other layout."""
    from skinfield.files.layouts.own_toml import EXTENSIONS, LAYOUT_KEYS, log_settings

    path = Path(layout)
    if path.suffix.lower() not in EXTENSIONS or not path.is_file():
        return None
    if LAYOUT_KEYS[0] not in text_of_file(layout):
        return None
    return load_settings(layout), log_settings(path) or LogSettings()


def log_of(layout: str | None) -> LogSettings | None:
    """How logs of a skin are read, where its file says so."""
    from skinfield.files.layouts.own_toml import log_settings

    return None if layout is None else log_settings(Path(layout))


def with_own(section: S, known: Section) -> S:
    """Section of settings in which those of a skin's file stand for those that are not set."""
    usual = {each.name: each.default for each in fields(section)}
    found = {
        name: getattr(known, name)
        for name, value in usual.items()
        if hasattr(known, name) and getattr(section, name) == value
    }
    return replace(section, **found)


def flag_of(name: str) -> str:
    """Flag of a field or parameter, without its dashes."""
    return FLAGS.get(name, name.strip("_").replace("_", "-").lower())


def flags_set(command: Callable[..., Any], values: dict[str, Any]) -> list[tuple[str, str]]:
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


def patch_of(skin: "sf.Skin", name: str | None) -> "sf.Patch":
    """The patch that is meant: the only one, or the one of this name or number (from 0)."""
    if name is not None:
        return skin[int(name)] if name.isdecimal() else skin[name]
    if len(skin) > 1:
        raise InputError(
            f"{skin.name} has {len(skin)} patches, expected one: choose with --patch from "
            f"{', '.join(patch.name for patch in skin)}"
        )
    return skin[0]


def processes(workers: int | None) -> int:
    """How many processes work at once: as many as are asked for, else one for each core."""
    return workers or processors()
