"""Make the picture of closed-forms.md, and print the numbers that it quotes.

python docs/closed_form_figures.py
"""

from pathlib import Path
from typing import Any

import click
import numpy as np

from skinfield.elastic import Layer
from skinfield.elastic.axisymmetric import Paraboloid, Taper, indent_to_radius, kappa
from skinfield.elastic.hertz import HertzSphere, SneddonCone, effective_modulus
from skinfield.elastic.thin_layer import (
    CORRECTIONS,
    DIMITRIADIS,
    GARCIA_PARABOLOID,
    GARCIA_PUNCH,
    SQUEEZE_PARABOLOID,
    SQUEEZE_PUNCH,
    Correction,
    cone_reach,
    edge_length,
    paraboloid_reach,
)
from skinfield.plot import save
from skinfield.plot.style import BLUE, FAINT, INK, ORANGE, QUIET, add_title, new_figure, style

IMAGES = Path(__file__).parent / "images"
H = 1e-3  # m; the curves have no dimension
GREEN = "#009e73"
RATIOS = {0.5: INK, 0.45: BLUE, 0.3: ORANGE}
SHARES = np.geomspace(0.05, 20.0, 60)


def paraboloid(a_over_h: float, nu: float) -> tuple[float, float, float]:
    """Reach, force over Hertz's at the same depth, depth over Hertz's at the same force."""
    layer, radius = Layer(H, 1.0, nu), 1.0
    state = indent_to_radius(layer, Paraboloid(radius=radius), a_over_h * H)
    star = effective_modulus(1.0, nu)
    same_depth = HertzSphere.from_depth(radius=radius, modulus=star, depth=state.depth)
    same_force = HertzSphere.from_force(radius=radius, modulus=star, force=state.force)
    reach = paraboloid_reach(radius, state.depth, H)
    return reach, state.force / same_depth.force, state.depth / same_force.depth


def cone(a_over_h: float, nu: float) -> tuple[float, float]:
    """Reach, and force over Sneddon's at the same depth."""
    state = indent_to_radius(Layer(H, 1.0, nu), Taper(slope=0.1), a_over_h * H)
    star = effective_modulus(1.0, nu)
    free = SneddonCone.from_depth(slope=0.1, modulus=star, depth=state.depth)
    return cone_reach(0.1, state.depth, H), state.force / free.force


def with_range(
    axes: Any, correction: Correction, reach: Any, colour: str, label: str, wide: float
) -> None:
    """A formula against a/h: thick where it is within 5 %, dotted where it is not."""
    values = correction(reach, 0.5, beyond_range=True)
    low, high = correction.valid_a_over_h(0.5, 0.05)
    good = (low <= SHARES) & (high >= SHARES)
    positive = values > 0
    axes.plot(SHARES[positive], values[positive], ":", color=colour, lw=1.2)
    axes.plot(SHARES[good], values[good], color=colour, lw=wide, alpha=0.7, label=label)


def draw() -> None:
    """Depth by Poisson's ratio; force of a paraboloid and of a flat end beside formulas."""
    with style():
        figure = new_figure(10.0, 4.1)
        panels = [figure.add_axes((0.06 + 0.325 * i, 0.13, 0.26, 0.68)) for i in range(3)]
        for nu, colour in RATIOS.items():
            curve = [paraboloid(float(a), nu)[2] for a in SHARES]
            panels[0].plot(SHARES, curve, color=colour, label=f"ν = {nu:g}")
        panels[0].set(ylabel="depth / depth by Hertz at the same force", ylim=(0, 1))
        add_title(panels[0], "a", "Depth", "paraboloid on the bonded layer, exact")
        round_body = np.array([paraboloid(float(a), 0.5)[:2] for a in SHARES]).T
        for axes, reach, exact, formulas in (
            (
                panels[1],
                *round_body,
                {
                    "Garcia 2018": (GARCIA_PARABOLOID, GREEN, 7.0),
                    "Dimitriadis 2002": (DIMITRIADIS, BLUE, 3.5),
                    "squeezed film": (SQUEEZE_PARABOLOID, ORANGE, 7.0),
                },
            ),
            (
                panels[2],
                SHARES,
                np.array([kappa(float(a), 0.5) for a in SHARES]),
                {
                    "Garcia 2018": (GARCIA_PUNCH, GREEN, 7.0),
                    "squeezed film with its edge": (SQUEEZE_PUNCH, ORANGE, 7.0),
                },
            ),
        ):
            for label, (correction, colour, wide) in formulas.items():
                with_range(axes, correction, reach, colour, label, wide)
            axes.plot(SHARES, exact, color=INK, lw=1.0, label="exact")
            axes.set(yscale="log", ylim=(0.8, 3e3))
            axes.set_yticks([1, 10, 100, 1000], ["1", "10", "100", "1000"])
            axes.set_ylabel("force / force on the half-space, same depth")
        add_title(panels[1], "b", "Force, paraboloid, ν = 0.5", "thick: within 5 %; dotted: not")
        add_title(panels[2], "c", "Force, flat end, ν = 0.5", "thick: within 5 %; dotted: not")
        for axes in panels:
            axes.set(xscale="log", xlabel="contact radius / thickness, a/h", xlim=(0.05, 20))
            axes.set_xticks([0.1, 1, 10], ["0.1", "1", "10"])
            axes.axvspan(0.5, 3.0, color=FAINT, alpha=0.3, lw=0)
            axes.grid(color=FAINT, lw=0.5, alpha=0.6)
            axes.spines[["top", "right"]].set_visible(False)
            axes.legend(frameon=False, fontsize=8, labelcolor=INK)
        panels[0].text(1.22, 0.965, "skins", color=QUIET, fontsize=8, ha="center", va="top")
        save(figure, IMAGES / "closed-forms.png")


def tell() -> None:
    """Print factors and ranges."""
    click.echo("a/h: depth over Hertz's at ν = 0.3, 0.45, 0.5 | force factor of a paraboloid, "
               "a cone and a flat end at ν = 0.5")  # fmt: skip
    for a in (0.1, 0.2, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0):
        depths = [f"{paraboloid(a, nu)[2]:.3f}" for nu in (0.3, 0.45, 0.5)]
        forces = paraboloid(a, 0.5)[1], cone(a, 0.5)[1], kappa(a, 0.5)
        click.echo(f"  {a:g}: {' '.join(depths)} | {' '.join(f'{f:.4g}' for f in forces)}")
    click.echo("formula, ν: a/h within 1 % and 5 %")
    for correction in CORRECTIONS:
        for nu in sorted({each.poisson_ratio for each in correction.ranges}):
            one, five = (r.a_over_h for r in correction.ranges if r.poisson_ratio == nu)
            click.echo(f"  {correction.name}, {nu:g}: {one} {five}")
    click.echo(f"edge lengths: {[(nu, round(edge_length(nu), 4)) for nu in (0, 0.3, 0.45, 0.5)]}")


if __name__ == "__main__":
    IMAGES.mkdir(exist_ok=True)
    draw()
    tell()
