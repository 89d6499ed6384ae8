"""Settings of a live skin: one tree of typed values, with their units in their names.

The same tree is a TOML file, the command line and the JSON in a recording.
"""

from dataclasses import asdict, dataclass, field
from math import inf
from pathlib import Path
from typing import Annotated, Any, Literal

from skinfield.bridges.settings import BridgeSettings
from skinfield.emulator.settings import NO_HABITS, HabitsName
from skinfield.errors import InputError
from skinfield.page.settings import PageSettings
from skinfield.settings import (
    Positive,
    Range,
    Section,
    SettingError,
    pair_from_text,
    plain_from_toml,
    text_of_file,
    value_of_tables,
)

SolverName = Literal[
    "auto", "gaussian", "nonnegative", "tikhonov", "pseudo-inverse", "inverse", "contact"
]
MechanicsName = Literal["layer", "covered-layer", "half-space"]
QuantityName = Literal["capacitance", "gap", "stress"]
FASTEST = 1e5  # cycles per second


@dataclass(frozen=True, kw_only=True)
class Elastomer(Section):
    """What is known of the elastomer; what is left out is the profile's.

    Parameters
    ----------
    profile : str
        Whose skin it is: generic, icub, cyskin, silicone-2mm, or a file (.toml); auto goes by the
        boards and the layout.
    thickness_mm : float, mm, optional
        Thickness of the elastomer, mm.
    modulus_kpa : float, kPa, optional
        Young's modulus, kPa.
    poisson : float, optional
        Poisson's ratio, 0 to 0.5.
    relaxed_fraction : float, optional
        Of the modulus, what is left after long; the elastomer's creep is then undone. Default 1.
    relaxation_s : float, s, optional
        Time constant of the relaxation, s.
    """

    profile: str = "auto"
    thickness_mm: Annotated[float | None, Positive("thickness of the elastomer")] = None
    modulus_kpa: Annotated[float | None, Positive("Young's modulus")] = None
    poisson: Annotated[float | None, Range(0.0, 0.5, "Poisson's ratio")] = None
    relaxed_fraction: Annotated[float | None, Range(0.1, 1.0, "1 is elastic")] = None
    relaxation_s: Annotated[float | None, Positive("time constant, in s")] = None

    def check(self) -> None:
        """See `Section`."""
        super().check()
        if (self.relaxed_fraction is None) != (self.relaxation_s is None):
            raise self.wrong(
                "relaxed_fraction" if self.relaxation_s is None else "relaxation_s",
                "both relaxed_fraction and relaxation_s, or neither: one says nothing alone",
            )


MOST_DIGITS = 10  # of the number of a taxel


def taxels_of(flag: str, text: str | None, taxels: int | None = None) -> tuple[int, ...]:
    """Rows of taxels, such as 3,17-20; InputError for what is none, or is not of the patch."""
    rows: list[int] = []
    for word in (text or "").split(",") if text is not None else ():
        ends = word.strip().split("-")
        if len(ends) > 2 or not all(end.isdecimal() and len(end) < MOST_DIGITS for end in ends):
            raise InputError(f"{flag} is {text!r}, expected taxels such as 3,17-20")
        first, last = int(ends[0]), int(ends[-1])
        if last < first or (taxels is not None and last >= taxels):
            most = "in ascending order" if taxels is None else f"of the patch, 0 to {taxels - 1}"
            raise InputError(f"{flag} names taxels {word.strip()}, expected rows {most}")
        if taxels is not None:
            rows += range(first, last + 1)
    if flag == "--without" and taxels is not None and len(set(rows)) == taxels:
        raise InputError(f"--without names all {taxels} taxels, expected some that are left")
    return tuple(rows)


@dataclass(frozen=True, kw_only=True)
class TaxelSettings(Section):
    """What the counts of each taxel mean, and which taxels are used.

    Parameters
    ----------
    no_load : int, optional
        What an iCub byte rests at. Default the profile's, else 240.
    gain : float, optional
        Counts per unit of ΔC/C₀; negative where pressure lowers them. Default the profile's.
    calibration : str, optional
        Calibration file (.toml, .npz) instead of both.
    keep : str, optional
        Taxels to use whatever is found faulty, such as 3,17-20: rows of the patch, from 0.
    without : str, optional
        Taxels to leave out.
    """

    no_load: Annotated[int | None, Range(1, 255, "what an iCub byte rests at")] = None
    gain: float | None = None
    calibration: str | None = None
    keep: str | None = None
    without: str | None = None

    def check(self) -> None:
        """See `Section`."""
        super().check()
        for name in ("keep", "without"):
            try:
                taxels_of(name, getattr(self, name))
            except InputError as error:
                raise SettingError(name, str(error).removeprefix(f"{name} ")) from error
        if self.gain is not None and not 0 < abs(self.gain) < inf:
            raise self.wrong("gain", "counts per unit of ΔC/C₀, not 0")


@dataclass(frozen=True, kw_only=True)
class SkinSettings(TaxelSettings, Elastomer):
    """Where the taxels are, under what, and what a count means; see also `Elastomer`.

    Parameters
    ----------
    layout : str or several
        Layout file, or a generator by name; on a robot LINK=LAYOUT, again for more, or all of it.
    urdf : str, optional
        URDF of the robot that it is on.
    """

    layout: str | tuple[str, ...] = "hexagon72"
    urdf: str | None = None

    def check(self) -> None:
        """See `Section`."""
        super().check()
        if self.urdf is None and len(self.layouts) != 1:
            raise self.wrong("layout", "one; several are parts of a robot, with --robot its URDF")
        if self.urdf is not None and self.layout == type(self).layout:
            raise self.wrong("layout", "--skin LINK=LAYOUT, or the layout of all parts, of a robot")

    @property
    def layouts(self) -> tuple[str, ...]:
        """All that are given."""
        return (self.layout,) if isinstance(self.layout, str) else self.layout

    @property
    def first(self) -> str:
        """The layout that is given first, without its link."""
        return next(iter(self.parts().values()))[0] if self.urdf else self.layouts[0]

    def parts(self) -> dict[str, list[str]]:
        """Layouts by the link or part that they are for; "" for those of all parts."""
        found: dict[str, list[str]] = {}
        for text in self.layouts:
            part, equals, layout = text.partition("=")
            if not equals or ":" in part:  # a generator with its numbers
                part, layout = "", text
            found.setdefault(part, []).append(layout)
        return found


@dataclass(frozen=True, kw_only=True)
class SourceSettings(Section):
    """Where readings come from; without hardware, a virtual skin that is started for it.

    Parameters
    ----------
    hardware : str, optional
        Whose boards: icub, yarp, cyskin, packet. Without it a virtual skin is started.
    bus : str, optional
        How it is connected: udp (CAN in UDP), socketcan, serial ...
    channel : tuple of str
        Of the bus: can0, an address and port, a device; again for several buses.
    options : tuple of str
        A setting of the source, such as config=robot.xml; again for more.
    scene : str
        What presses the virtual skin.
    habits : str
        Of the virtual skin: none, or real.
    virtual_rate_hz : float, 1/s
        Readings of the virtual skin per second.
    seed : int
        Of the virtual skin's noise.
    """

    hardware: str | None = None
    bus: str | None = None
    channel: tuple[str, ...] = ()
    options: tuple[str, ...] = ()
    scene: str = "press"
    habits: HabitsName = NO_HABITS
    virtual_rate_hz: Annotated[float, Positive("readings per second")] = 100.0
    seed: Annotated[int, Range(0, 1 << 63, "of the virtual skin's noise")] = 0

    def check(self) -> None:
        """See `Section`."""
        self.named_options  # noqa: B018 - refuses what is no KEY=VALUE

    @property
    def named_options(self) -> dict[str, str]:
        """Further settings of the source, by name."""
        return dict(pair_from_text("options", text, "config=robot.xml") for text in self.options)


@dataclass(frozen=True, kw_only=True)
class ModelSettings(Section):
    """What a taxel reads of a traction, and how that is inverted.

    Parameters
    ----------
    solver : str, optional
        What readings are explained by. Default auto: few contacts or a field, by evidence.
    mechanics : str, optional
        Model of the elastomer; the paper's is the half-space. Default the profile's.
    quantity : str, optional
        What a taxel reads. Default what the recording's unit says, else capacitance.
    grid : int, optional
        Nodes on a side of the finest grid. Default by pitch and extent of the patch.
    """

    solver: SolverName | None = None
    mechanics: MechanicsName | None = None
    quantity: QuantityName | None = None
    grid: Annotated[int | None, Range(4, 1000, "4 nodes on a side or more")] = None


@dataclass(frozen=True, kw_only=True)
class LoopSettings(Section):
    """When cycles are, what they publish, and what is asked of the system.

    Parameters
    ----------
    name : str
        By which other programs find it.
    rate_hz : float, 1/s
        Cycles per second.
    events : bool
        A cycle when readings arrive, at no rate.
    deadline_us : float, µs, optional
        Time for the reconstruction in each cycle, µs.
    late_after_ms : float, ms, optional
        When an estimate counts as late, ms; by default after one period.
    threshold_n : float, N
        Contacts of a smaller force are not published, N.
    smoothing_ms : float, ms
        Time constant of a low-pass of what each taxel reads, ms; 0: none.
    tare_s : float, s
        Time of an untouched skin at the start, for its baseline, s.
    priority : int
        Of SCHED_FIFO, where it is granted; 0: not asked for.
    cpu : int, optional
        Processor to pin the engine to. Default an isolated one.
    """

    name: str = "skin"
    rate_hz: Annotated[
        float, Positive("cycles per second; or events: a cycle when readings arrive")
    ] = 1000.0
    events: bool = False
    deadline_us: Annotated[float | None, Positive("microseconds")] = None
    late_after_ms: Annotated[float | None, Positive("milliseconds")] = None
    threshold_n: Annotated[float, Range(0.0, 5.0, "N, of contacts")] = 0.0
    smoothing_ms: Annotated[float, Range(0.0, 1000.0, "ms; 0: none")] = 0.0
    tare_s: Annotated[float, Positive("seconds of an untouched skin")] = 1.0
    priority: Annotated[int, Range(0, 99, "of SCHED_FIFO; 0: not asked for")] = 80
    cpu: Annotated[int | None, Range(0, 1 << 16, "number of a processor")] = None

    def check(self) -> None:
        """See `Section`."""
        if self.rate_hz > FASTEST:
            raise self.wrong("rate_hz", f"{FASTEST:g} cycles per second at most")
        period = 1e6 / self.rate_hz
        if self.deadline_us is not None and not self.events and self.deadline_us >= period:
            raise self.wrong(
                "deadline_us",
                f"less than the period of {period:g} µs at {self.rate_hz:g} cycles per second: "
                "taking in readings needs time too",
            )


@dataclass(frozen=True, kw_only=True)
class RecordSettings(Section):
    """Into which file the skin is recorded.

    Parameters
    ----------
    into : str, optional
        Record into this MCAP file.
    """

    into: str | None = None


@dataclass(frozen=True, kw_only=True)
class Settings(Section):
    """All settings of a live skin, section by section."""

    skin: SkinSettings = field(default_factory=SkinSettings)
    source: SourceSettings = field(default_factory=SourceSettings)
    model: ModelSettings = field(default_factory=ModelSettings)
    loop: LoopSettings = field(default_factory=LoopSettings)
    page: PageSettings = field(default_factory=PageSettings)
    bridges: BridgeSettings = field(default_factory=BridgeSettings)
    record: RecordSettings = field(default_factory=RecordSettings)


def load_settings(path: str | Path) -> Settings:
    """Read a file of settings; what it leaves out is as usual.

    Raises
    ------
    FileError
        If it cannot be read, or holds what is not known or cannot be used.
    """
    return settings_from_toml(text_of_file(path), str(path))


def settings_from_toml(text: str, path: str = "settings") -> Settings:
    """Settings of a TOML text; `path` is what errors call it.

    The text may be that of a skin's file, whose layout is the skin's then.

    Raises
    ------
    FileError
        If it is not TOML, or holds what is not known or cannot be used.
    """
    from skinfield.files.layouts.own_toml import LAYOUT_KEYS, LOG

    tables = plain_from_toml(text, path)
    if LAYOUT_KEYS[0] in tables:  # a skin's file, which is its layout
        for key in (*LAYOUT_KEYS, LOG):
            tables.pop(key, None)
        skin = tables.setdefault("skin", {})
        if isinstance(skin, dict):
            skin.setdefault("layout", path)
    return value_of_tables(Settings, tables, text, path)


def toml_from_settings(settings: Settings) -> str:
    """Text that `settings_from_toml` makes equal settings of: what differs from the usual."""
    import tomli_w

    return tomli_w.dumps(changed(settings))


def changed(settings: Settings) -> dict[str, dict[str, Any]]:
    """Values that differ from the usual ones, by section and name."""
    plain, usual = asdict(settings), asdict(Settings())
    found = {
        section: {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in values.items()
            if value != usual[section][name]
        }
        for section, values in plain.items()
    }
    return {section: values for section, values in found.items() if values}
