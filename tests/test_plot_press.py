"""The picture of a press: what stands in it, and that it fits."""

from pathlib import Path

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import InputError
from skinfield.plot import save
from skinfield.plot.press import draw_press, heading
from skinfield.simulate import Cylinder, Press, Ring, Sphere, press

LAYER = sf.Layer(2e-3, 100e3)


@pytest.fixture(scope="module")
def two() -> Press:
    bodies = [
        Sphere(radius=6e-3, position=(-6e-3, 2e-3), force=1.0),
        Ring(inner_radius=3e-3, outer_radius=5e-3, position=(7e-3, 0.0), force=0.5),
    ]
    return press(LAYER, bodies, extent=40e-3, cell=0.5e-3)


def texts(figure) -> str:
    return "\n".join(text.get_text() for text in figure.findobj(lambda a: hasattr(a, "get_text")))


def test_panels_have_titles_units_and_the_true_numbers(two: Press) -> None:
    figure = draw_press(two)
    words = texts(figure)
    assert "ball 1.00 N, ring 0.500 N on 2.00 mm of 100 kPa" in words
    assert f"contact {two.contact_area * 1e6:.1f} mm²" in words
    for label in ("pressure (kPa)", "base stress (kPa)", "indentation (mm)", "x (mm)", "y (mm)"):
        assert label in words
    image = figure.axes[0].images[0]
    assert image.get_array().max() == pytest.approx(two.pressure.max() / 1e3)
    low, high = figure.axes[0].get_xlim()
    touched = two.grid.plane[two.contact, 0] * 1e3
    assert low < touched.min() < touched.max() < high


def test_the_section_goes_through_the_strongest_body(two: Press) -> None:
    figure = draw_press(two)
    assert "at y = 1.75 mm" in texts(figure) or "at y = 2.25 mm" in texts(figure)
    section = next(axes for axes in figure.axes if "height over" in axes.get_ylabel())
    surface = section.lines[0].get_ydata()
    row = np.abs(two.grid.plane[:, 1] - 2e-3) < 0.3e-3
    assert -surface.min() == pytest.approx(-two.displacement[row, 2].min() * 1e3, rel=0.02)


def test_taxels_are_shown_with_their_readings(two: Press) -> None:
    patch = sf.layouts.hexagon72()
    figure = draw_press(two, patch)
    assert "72 taxels" in texts(figure)
    assert "ΔC/C₀ (%)" in texts(figure)
    stress = two.base_stress(patch.plane, patch.pad_diameter) / 1e3
    other = draw_press(two, patch, stress, label="base stress (kPa)")
    assert "base stress (kPa)" in texts(other)
    with pytest.raises(InputError, match=r"readings has shape \(3,\)"):
        draw_press(two, patch, np.zeros(3))


def test_many_bodies_have_a_heading_that_fits(tmp_path: Path) -> None:
    places = np.stack(np.meshgrid(np.arange(3), np.arange(3)), -1).reshape(-1, 2) * 9e-3 - 9e-3
    bodies = [Cylinder(radius=2e-3, position=(x, y), force=0.1) for x, y in places.tolist()]
    found = press(LAYER, bodies, extent=36e-3, cell=0.6e-3)
    assert heading(found) == "9 indenters, 0.900 N on 2.00 mm of 100 kPa"
    figure = draw_press(found)
    save(figure, tmp_path / "many.png")
    title = figure.texts[0].get_window_extent()
    assert title.x1 < figure.bbox.x1
