"""Profiles of real skins: elastomer, gain and rest of whose skin it is, a TOML file each."""

from dataclasses import dataclass
from importlib.resources import files
from typing import Annotated

from skinfield.cli.settings import Elastomer, MechanicsName
from skinfield.errors import InputError
from skinfield.settings import Positive, Range, Section, nearest, text_of_file, value_from_toml

PROFILES = ("generic", "icub", "cyskin", "silicone-2mm")
OF_HARDWARE = {"icub": "icub", "yarp": "icub", "cyskin": "cyskin", "shm": "cyskin"}
OF_FORMAT = {"icub-positions": "icub", "skingui": "icub", "cyskin": "cyskin"}  # of layouts
VALUES = ("thickness_mm", "modulus_kpa", "poisson")


@dataclass(frozen=True, kw_only=True)
class SkinProfile(Section):
    """What is known of a kind of skin.

    Parameters
    ----------
    name : str
    thickness_mm : float, mm
    modulus_kpa : float, kPa
        Young's modulus.
    poisson : float
    mechanics : str
        Model of the elastomer; covered-layer where a cover that does not stretch lies on it.
    gain : float, optional
        Counts per unit of ΔC/C₀; by default that of the boards.
    no_load : int, optional
        What an iCub byte rests at.
    assumed : tuple of str
        Values that nobody has measured.
    note : str
        What else is to be known of the values.
    """

    name: str
    thickness_mm: Annotated[float, Positive("thickness of the elastomer")]
    modulus_kpa: Annotated[float, Positive("Young's modulus")]
    poisson: Annotated[float, Range(0.0, 0.5, "Poisson's ratio")]
    mechanics: MechanicsName = "layer"
    gain: float | None = None
    no_load: Annotated[int | None, Range(1, 255, "what an iCub byte rests at")] = None
    assumed: tuple[str, ...] = ()
    note: str = ""

    def sentence(self, given: Elastomer) -> str:
        """Which profile it is, with the values that count; those that were given come first."""
        parts = []
        for name, unit in zip(VALUES, ("{:g} mm", "{:g} kPa", "ν {:g}"), strict=True):
            own = getattr(given, name)
            text = unit.format(getattr(self, name) if own is None else own)
            why = " as given" if own is not None else " (assumed)" if name in self.assumed else ""
            parts.append(text + why)
        if self.mechanics == "covered-layer":
            parts.append("covered")
        if self.gain is not None:
            parts.append(f"gain {self.gain:g}")
        if self.no_load is not None:
            parts.append(f"rest {self.no_load}")
        return f"profile {self.name}: {', '.join(parts)}" + (f"; {self.note}" if self.note else "")


def load_profile(name: str) -> SkinProfile:
    """Profile of a name in `PROFILES`, or of a file.

    Raises
    ------
    InputError
        If there is no profile of that name.
    FileError
        If the file cannot be read, or holds what is not known or cannot be used.
    """
    if name in PROFILES:
        text = files("skinfield.cli").joinpath("profiles", f"{name}.toml").read_text("utf-8")
        return value_from_toml(SkinProfile, text, name)
    if not name.endswith(".toml"):
        raise InputError(
            f"profile is {name!r}, expected one of {', '.join(PROFILES)}, or a file (.toml)"
            f"{nearest(name, PROFILES)}"
        )
    return value_from_toml(SkinProfile, text_of_file(name), name)


def profile_of(
    given: Elastomer, hardware: str | None = None, layout_format: str = ""
) -> SkinProfile:
    """Profile that is asked for; with "auto", that of the boards or the layout.

    A layout that is made by a generator is that of a virtual skin.

    Parameters
    ----------
    given : Elastomer
    hardware : str, optional
        Whose boards, as on the command line.
    layout_format : str
        As of `files.layouts.load.layout_format`.
    """
    if given.profile != "auto":
        return load_profile(given.profile)
    if layout_format == "generator":
        return load_profile("silicone-2mm")
    boards = OF_HARDWARE.get(hardware or "", "")
    return load_profile(boards or OF_FORMAT.get(layout_format, "generic"))
