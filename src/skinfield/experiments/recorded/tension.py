"""A silicone that was pulled to failure: where Hooke's law and the neo-Hookean law leave it."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skinfield.conditioning.tensile import TensileTest, load_tensile_test
from skinfield.conditioning.tension import ModulusFit, curve_from_tension, initial_modulus
from skinfield.errors import Floats
from skinfield.experiments.recorded.finding import Finding, Value, needed
from skinfield.experiments.words import png_of
from skinfield.figures.real_data import draw_tension

FILE = "elastomer-tensile", "Ecoflex 00-30.csv"
RANGES = (0.2, 0.3, 0.5, 1.0, 2.0)  # strains up to which the modulus is fitted
CHOSEN = 0.5
SOURCE = "LucMarechal/Soft-Robotics-Materials-Database, ODbL 1.0 and DbCL 1.0"


@dataclass(frozen=True, eq=False)
class Tension:
    """A tensile test and what two laws with one modulus make of it.

    Attributes
    ----------
    test : TensileTest
    fits : tuple of ModulusFit
        The neo-Hookean law fitted to strains up to each of `RANGES`.
    chosen : ModulusFit
        The one up to `CHOSEN`, whose modulus both laws take.
    noise : float, Pa
        Root mean square scatter of the stress about its own running mean.
    """

    test: TensileTest
    fits: tuple[ModulusFit, ...]
    chosen: ModulusFit
    noise: float

    def hooke(self, strain: Floats) -> Floats:
        """Stress, Pa, of Hooke's law with the chosen modulus and offset."""
        return self.chosen.offset + self.chosen.modulus * strain

    def neo_hooke(self, strain: Floats) -> Floats:
        """Engineering stress, Pa, of the incompressible neo-Hookean law."""
        stretch = 1.0 + strain
        return np.asarray(self.chosen.offset + self.chosen.modulus / 3.0 * (stretch - stretch**-2))

    def measured(self, strain: Floats) -> Floats:
        """Stress, Pa, of the test without the noise that makes it fall."""
        curve = curve_from_tension(self.test.strain, self.test.stress, compression_to=0.1)
        return -curve.stress_from_strain(-strain)  # it is positive in compression

    def off(self, law: str, strain: Floats) -> Floats:
        """Error of a law relative to the measured stress, both from the fit's zero."""
        model = self.hooke(strain) if law == "hooke" else self.neo_hooke(strain)
        measured = self.measured(strain) - self.chosen.offset
        return np.asarray((model - self.chosen.offset) / measured - 1.0)

    def leaves(self, law: str, share: float) -> float:
        """Strain from which on a law stays further off than a share; NaN if it never does."""
        low, high = float(self.test.strain.min()), 3.0
        strain = np.linspace(low, high, 1000)
        within = np.flatnonzero(np.abs(self.off(law, strain)) <= share)
        if len(within) == 0:
            return low
        last = int(within[-1]) + 1
        return float(strain[last]) if last < len(strain) else float("nan")


def tension(folder: Path) -> Tension:
    """Read the test and fit it.

    Raises
    ------
    AbsentData, FileError
        If the file is not there, or cannot be used.
    """
    test = load_tensile_test(needed(folder, *FILE))
    fits = tuple(initial_modulus(test.strain, test.stress, up_to=end) for end in RANGES)
    chosen = fits[RANGES.index(CHOSEN)]
    start = test.stress[test.strain <= 1.0]
    jumps = np.diff(start, n=2)  # of white noise, six times its variance
    return Tension(test, fits, chosen, float(np.sqrt(np.mean(jumps**2) / 6.0)))


def theory_leaves(share: float) -> float:
    """Strain at which Hooke's law exceeds the neo-Hookean one by a share."""
    from scipy.optimize import brentq

    def excess(strain: float) -> float:
        stretch = 1.0 + strain
        return 3.0 * strain / (stretch - stretch**-2) - 1.0 - share

    return float(brentq(excess, 1e-6, 3.0))


def stretched_elastomer(folder: Path) -> Finding:
    """See `Tension`; in words."""
    found = tension(folder)
    moduli = [fit.modulus / 1e3 for fit in found.fits]
    at = np.array([0.1, 0.2, 0.5, 1.0, 2.0, 3.0])
    hooke, neo = found.off("hooke", at), found.off("neo-hooke", at)

    def figure() -> bytes:
        strain = np.linspace(0.0, 3.0, 300)
        laws = {"Hooke": found.hooke(strain), "neo-Hooke": found.neo_hooke(strain)}
        return png_of(draw_tension(found.test.strain, found.test.stress, strain, laws))

    sentences = (
        f"{found.test.material}: Young's modulus at zero strain is "
        f"{found.chosen.modulus / 1e3:.1f} ± {found.chosen.std / 1e3:.1f} kPa by the neo-Hookean "
        f"law up to a strain of {CHOSEN:g}; taken up to {RANGES[0]:g} to {RANGES[-1]:g} it is "
        f"{min(moduli):.1f} to {max(moduli):.1f} kPa, so the choice of the range matters more than "
        f"the scatter of {found.noise:.0f} Pa.",
        f"Hooke's law with this modulus is {100 * hooke[1]:.0f} % above the test at a strain of "
        f"{at[1]:g}, {100 * hooke[2]:.0f} % at {at[2]:g} and {100 * hooke[3]:.0f} % at {at[3]:g}. "
        f"It stays more than 5 % off from {found.leaves('hooke', 0.05):.2f} on and more than 10 % "
        f"from {found.leaves('hooke', 0.10):.2f} on (by the neo-Hookean law "
        f"{theory_leaves(0.05):.3f} and {theory_leaves(0.10):.3f}).",
        f"The neo-Hookean law is within {100 * np.abs(neo[1:3]).max():.0f} % from {at[1]:g} to "
        f"{at[2]:g}; it is {100 * neo[3]:+.0f} % at {at[3]:g} and {100 * neo[5]:+.0f} % at "
        f"{at[5]:g}. It leaves the test by more than 10 % for good from a strain of "
        f"{found.leaves('neo-hooke', 0.10):.2f}.",
        "Engineering stress and strain in tension, a crosshead's strain; skin is compressed.",
    )
    rows: list[dict[str, Value]] = [
        {
            "strain": float(strain),
            "stress measured (kPa)": round(float(found.measured(strain)) / 1e3, 2),
            "Hooke's law (%)": round(100 * float(a), 1),
            "neo-Hookean law (%)": round(100 * float(b), 1),
        }
        for strain, a, b in zip(at, hooke, neo, strict=True)
    ]
    return Finding(
        name="elastomer",
        title="a silicone's measured stress and strain",
        source=SOURCE,
        sentences=sentences,
        rows=tuple(rows),
        figure=figure,
        caption="Tension of the test beside two laws with the same modulus at zero strain.",
    )
