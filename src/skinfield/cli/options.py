"""Options that commands share, and the objects that they stand for: the only list of variants."""

from collections.abc import Callable
from typing import Any, TypeVar

import click
from numpy.typing import ArrayLike

from skinfield.conditioning import (
    Convention,
    CySkinCount,
    Exponential,
    Filter,
    ICubByte,
    NoFilter,
    load_calibration,
)
from skinfield.errors import InputError
from skinfield.inverse import (
    ContactFit,
    GaussianField,
    Inverse,
    NonNegative,
    PseudoInverse,
    Solver,
    Tikhonov,
)
from skinfield.layout import Grid, Patch, Skin
from skinfield.mechanics import BondedLayer, HalfSpace, Layer, Mechanics
from skinfield.observation import BaseStress, Capacitance, Gap, Quantity
from skinfield.pipeline import Reconstructor
from skinfield.pipeline.conditioned import Conditioning

F = TypeVar("F", bound=Callable[..., Any])

SOLVERS: dict[str, Callable[[], Solver]] = {
    "gaussian": GaussianField,
    "contact": ContactFit,
    "nonnegative": NonNegative,
    "tikhonov": Tikhonov,
    "pseudo-inverse": PseudoInverse,
    "inverse": Inverse,
}
MECHANICS: dict[str, Callable[[], Mechanics]] = {
    "layer": BondedLayer,
    "covered-layer": lambda: BondedLayer(inextensible_cover=True),
    "half-space": HalfSpace,
}
QUANTITIES: dict[str, Callable[[], Quantity]] = {
    "capacitance": Capacitance,
    "gap": Gap,
    "stress": BaseStress,
}
OF_UNIT = {"count": "capacitance", "dC/C0": "capacitance", "Pa": "stress", "1": "gap"}


def layer_options(function: F) -> F:
    """Options of the elastomer."""
    for option in (
        click.option(
            "--poisson", default=0.5, show_default=True, help="Poisson's ratio, 0 to 0.5."
        ),
        click.option(
            "--modulus-kpa", default=150.0, show_default=True, help="Young's modulus, kPa."
        ),
        click.option(
            "--thickness-mm", default=2.0, show_default=True, help="Of the elastomer, mm."
        ),
    ):
        function = option(function)
    return function


def model_options(grid: int) -> Callable[[F], F]:
    """Options of grid (with its default), mechanics and solver, and of the elastomer."""
    options = (
        click.option(
            "--grid", default=grid, show_default=True, help="Nodes on a side of the grid."
        ),
        click.option(
            "--solver",
            type=click.Choice(list(SOLVERS)),
            default="gaussian",
            show_default=True,
            help="How readings become pressure; contact fits the fewest contacts instead.",
        ),
        click.option(
            "--mechanics",
            type=click.Choice(list(MECHANICS)),
            default="layer",
            show_default=True,
            help="Model of the elastomer; the paper's is the half-space.",
        ),
        click.option(
            "--quantity",
            type=click.Choice(["auto", *QUANTITIES]),
            default="auto",
            show_default=True,
            help="What a taxel reads; auto takes what the recording's unit says.",
        ),
    )

    def decorate(function: F) -> F:
        for option in options:
            function = option(function)
        return layer_options(function)

    return decorate


def conditioning_options(function: F) -> F:
    """Options of what counts mean."""
    for option in (
        click.option(
            "--board",
            type=click.Choice(["auto", "icub", "cyskin"]),
            default="auto",
            show_default=True,
            help="Whose counts they are; auto goes by their range.",
        ),
        click.option(
            "--no-load", default=240, show_default=True, help="What an iCub byte rests at."
        ),
        click.option(
            "--gain",
            type=float,
            help="Counts per unit of ΔC/C₀; negative where pressure lowers them. Default a guess.",
        ),
        click.option("--calibration", help="Calibration file (.toml, .npz) instead of both."),
        click.option(
            "--smooth-ms", default=0.0, help="Time constant of an exponential filter, ms."
        ),
        click.option(
            "--noise", type=float, help="Standard deviation of a reading, in the quantity's unit."
        ),
    ):
        function = option(function)
    return function


def layer_from_options(thickness_mm: float, modulus_kpa: float, poisson: float) -> Layer:
    """Elastomer, in SI units."""
    return Layer(thickness_mm * 1e-3, modulus_kpa * 1e3, poisson)


def reconstructor_from_options(
    patch: Patch, layer: Layer, quantity: Quantity, noise_std: ArrayLike, options: dict[str, Any]
) -> Reconstructor:
    """Reconstruction with the chosen grid, mechanics and solver."""
    return Reconstructor(
        patch,
        layer,
        Grid.square(patch, nodes=options["grid"]),
        mechanics=MECHANICS[options["mechanics"]](),
        quantity=quantity,
        solver=SOLVERS[options["solver"]](),
        noise_std=noise_std,
    )


def conditioning_from_options(
    patch: Patch,
    *,
    board: str,
    no_load: int,
    gain: float | None,
    calibration: str | None,
    smooth_ms: float,
    noise: float | None,
) -> Conditioning:
    """What counts mean."""
    conventions: dict[str, Convention | None] = {
        "auto": None if no_load == 240 else ICubByte(no_load=no_load),
        "icub": ICubByte(no_load=no_load),
        "cyskin": CySkinCount(),
    }
    if not 0.0 <= smooth_ms < float("inf"):
        raise InputError(f"--smooth-ms is {smooth_ms!r}, expected 0 (no filter) or more")
    smooth: Filter = Exponential(time_constant=smooth_ms * 1e-3) if smooth_ms else NoFilter()
    return Conditioning(
        board=conventions[board],
        gain=gain,
        calibration=None if calibration is None else load_calibration(calibration, patch),
        filter=smooth,
        noise_std=noise,
    )


def patch_of(skin: Skin, name: str | None) -> Patch:
    """The patch that is meant: the only one, or the one of this name or number (from 0)."""
    if name is not None:
        return skin[int(name)] if name.isdecimal() else skin[name]
    if len(skin) > 1:
        raise InputError(
            f"{skin.name} has {len(skin)} patches, expected one: choose with --patch from "
            f"{', '.join(patch.name for patch in skin)}"
        )
    return skin[0]
