"""Make the picture of docs/how-to/simulate.md: every shape pressed with 1 N on the same skin.

python docs/figures/indenters.py
"""

import tempfile
from pathlib import Path
from typing import Any

import click
import numpy as np

import skinfield as sf
from skinfield.plot import INK, QUIET, new_figure, number, save, signed_colours, style
from skinfield.simulate import (
    Bar,
    Cone,
    Cylinder,
    HeightMap,
    Indenter,
    Mesh,
    Press,
    Ring,
    Rod,
    Sphere,
    Wedge,
    press,
)
from skinfield.simulate.indenters.shape_files import load_height_map, load_mesh

IMAGES = Path(__file__).parents[1] / "images"
LAYER = sf.Layer(2e-3, 150e3)
SIDE = 8.0  # mm from the middle to the border of a map
MM = 1e-3


def stamp(folder: Path) -> HeightMap:
    """An F of 1 mm relief, by way of a picture."""
    from PIL import Image

    grey = np.zeros((100, 80), np.uint8)
    grey[5:95, 10:30] = grey[5:25, 10:70] = grey[42:60, 10:58] = 255
    Image.fromarray(grey).save(folder / "f.png")
    return load_height_map(folder / "f.png", pixel=0.12 * MM, relief=1 * MM)


def star(folder: Path) -> Mesh:
    """A star whose middle stands out, by way of an STL file."""
    import trimesh

    turn = np.linspace(0, 2 * np.pi, 11)[:-1] + np.pi / 2
    reach = np.where(np.arange(10) % 2, 3.0, 7.0)
    rim = np.column_stack([reach * np.cos(turn), reach * np.sin(turn), np.full(10, 0.5)])
    faces = [[10, index, (index + 1) % 10] for index in range(10)]
    trimesh.Trimesh(np.vstack([rim, np.zeros((1, 3))]), faces).export(folder / "star.stl")
    return load_mesh(folder / "star.stl")


def bodies(folder: Path) -> dict[str, Indenter]:
    """Shapes with their sizes in words."""
    lean = (0.0, np.radians(3.0))
    steep = np.radians(75.0)
    return {
        "Sphere, radius 6": Sphere(radius=6 * MM),
        "Cylinder, radius 5": Cylinder(radius=5 * MM),
        "… edge_radius 1": Cylinder(radius=5 * MM, edge_radius=1 * MM),
        "… leaning 3° about y": Cylinder(radius=5 * MM, tilt=lean),
        "Cone, half angle 75°": Cone(radius=7 * MM, half_angle=steep),
        "Wedge, half angle 75°": Wedge(length=10 * MM, width=8 * MM, half_angle=steep),
        "Bar, 12 × 3, turned 30°": Bar(length=12 * MM, width=3 * MM, rotation=np.pi / 6),
        "Rod, radius 3, leaning 3°": Rod(radius=3 * MM, length=12 * MM, tilt=lean),
        "Ring, 4 to 6": Ring(inner_radius=4 * MM, outer_radius=6 * MM),
        "… round, leaning 1°": Ring(
            inner_radius=4 * MM, outer_radius=6 * MM, edge_radius=1 * MM,
            tilt=(np.radians(1.0), 0.0),
        ),
        "HeightMap, an F from a PNG": stamp(folder),
        "Mesh, a star from an STL": star(folder),
    }  # fmt: skip


def draw_map(axes: Any, found: Press, words: str) -> None:
    """Pressure below one body, with the outline of touch and the numbers."""
    pressure = found.pressure.reshape(found.grid.shape) / 1e3
    colours, scale = signed_colours(pressure)
    half = found.grid.shape[0] * found.grid.pitch / MM / 2
    axes.imshow(
        pressure, origin="lower", extent=(-half, half, -half, half), cmap=colours, norm=scale
    )
    for outline in found.outline:
        axes.plot(*(outline.T / MM), color=INK, lw=0.8)
    numbers = (
        f"{number(found.approach[0] / MM, 2)} mm deep, {number(found.contact_area * 1e6, 2)} mm², "
        f"peak {number(pressure.max(), 2)} kPa"
    )
    axes.set_title(words, fontsize=9, fontweight="bold", loc="left", pad=15)
    axes.text(0, 1.025, numbers, transform=axes.transAxes, fontsize=7, color=QUIET)
    axes.set(xlim=(-SIDE, SIDE), ylim=(-SIDE, SIDE), xticks=(-5, 0, 5), yticks=(-5, 0, 5))


@click.command(help=__doc__)
def main() -> None:
    """Draw, save, say the numbers."""
    with tempfile.TemporaryDirectory() as folder, style():
        shapes = bodies(Path(folder))
        figure = new_figure(9.6, 8.6)
        panels = np.asarray(figure.subplots(3, 4)).ravel()
        figure.subplots_adjust(
            left=0.06, right=0.985, top=0.93, bottom=0.06, hspace=0.33, wspace=0.2
        )
        for axes, (words, body) in zip(panels, shapes.items(), strict=True):
            found = press(LAYER, [body], extent=2 * SIDE * MM, cell=0.16 * MM)
            draw_map(axes, found, words)
            click.echo(
                f"{words}: {found.approach[0] / MM:.3f} mm, {found.contact_area * 1e6:.1f} mm2, "
                f"residual {found.residual:.1e}"
            )
        for axes in panels[8:]:
            axes.set_xlabel("x (mm)")
        for axes in panels[::4]:
            axes.set_ylabel("y (mm)", labelpad=1)
        save(figure, IMAGES / "indenters.png", dpi=110)


if __name__ == "__main__":
    main()
