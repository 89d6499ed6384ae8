"""Figures are drawn from estimates made by hand, so that every number in them is known."""

import subprocess
import sys
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.path import Path
from matplotlib.text import Text
from matplotlib.transforms import Affine2D

import skinfield as sf
from skinfield import plot
from skinfield.errors import FileError, InputError
from skinfield.estimate import Contact, Estimate
from skinfield.estimate.developed_plane import Chart
from skinfield.estimate.plot import draw_estimate
from skinfield.plot import duration, number, plus_minus, signed_colours
from skinfield.signal.plot import draw_timeline
from skinfield.simulate import Cylinder, Press, Ring, Sphere, press
from skinfield.simulate.pressing.plot import draw_press, heading


def hexagon_patch() -> sf.Patch:
    return replace(sf.layouts.hexagon72(), name="palm")


def bump(grid: sf.Grid, centre: np.ndarray, force: float, radius: float) -> np.ndarray:
    distance = np.linalg.norm(grid.positions - centre, axis=1)
    pressure = np.exp(-2 * (distance / radius) ** 2)
    return pressure * force / (pressure.sum() * grid.cell_area)


def contact_of(grid: sf.Grid, pressure: np.ndarray, std: float = 0.03) -> Contact:
    cells = np.flatnonzero(pressure > 0.2 * pressure.max())
    weight = pressure[cells] / pressure[cells].sum()
    middle = weight @ grid.plane[cells]
    area = len(cells) * grid.cell_area
    radius = np.sqrt(area / np.pi)
    turn = np.linspace(0, 2 * np.pi, 40)
    rim = middle + radius * np.column_stack([np.cos(turn), np.sin(turn)])
    frame = grid.patch.surface.frame_from_plane(middle[None])[0]
    force = pressure[cells].sum() * grid.cell_area
    return Contact(
        position=grid.patch.surface.position_from_plane(middle[None])[0],
        force=-force * frame[:, 2],
        moment=np.zeros(3),
        normal=frame[:, 2],
        area=area,
        peak_pressure=pressure.max(),
        covariance=np.diag([1e-8, 1e-8, std**2]),
        area_std=0.0,
        radius=radius,
        shape="other",
        outline=grid.patch.surface.position_from_plane(rim),
        axes=np.array([1.2 * radius, 0.8 * radius]),
        angle=0.5,
        cells=cells,
    )


def estimate_of(grid: sf.Grid, presses: list[tuple[np.ndarray, float, float]]) -> Estimate:
    """Gaussian bumps of pressure; 0.1 mm of indentation at 50 kPa, a bulge beside it."""
    bumps = [bump(grid, *press) for press in presses]
    wide = [bump(grid, at, force, 1.8 * radius) for at, force, radius in presses]
    pressure, around = (np.sum([np.zeros(len(grid)), *each], axis=0) for each in (bumps, wide))
    depth, taxels = (1.4 * pressure - around) * 2e-9, len(grid.patch)
    contacts = sorted((contact_of(grid, one) for one in bumps), key=lambda c: -c.normal_force)
    return Estimate(
        grid=grid,
        pressure=pressure,
        traction=-pressure[:, None] * grid.normals,
        displacement=-depth[:, None] * grid.normals,
        pressure_std=np.full(len(grid), 400.0),
        contacts=tuple(contacts),
        residual=np.linspace(-0.01, 0.01, taxels),
        valid=np.ones(taxels, dtype=bool),
        readings=np.zeros(taxels),
        readings_std=np.ones(taxels),
        latency=40e-6,
    )


def readings_of(estimate: Estimate) -> np.ndarray:
    taxels = estimate.grid.patch.positions
    near = np.linalg.norm(taxels[:, None] - estimate.grid.positions, axis=-1).argmin(axis=1)
    return estimate.pressure[near] * 1.5e-6 - 0.004


def two_presses() -> tuple[Estimate, np.ndarray, list[tuple[np.ndarray, float, float]]]:
    presses = [
        (np.array([0.008, 0.004, 0.0]), 1.0, 5e-3),
        (np.array([-0.011, -0.008, 0.0]), 0.45, 4e-3),
    ]
    estimate = estimate_of(sf.Grid.square(hexagon_patch(), 24), presses)
    return estimate, readings_of(estimate), presses


def words_of(figure: Figure) -> list[str]:
    """Every visible text of the figure."""
    texts = [t.get_text() for t in figure.findobj(Text) if t.get_visible()]
    return [words for words in texts if words.strip()]


def panel(figure: Figure, title: str) -> Axes:
    """The axes whose heading ends in `title`."""
    for axes in figure.axes:
        if any(t.get_text().endswith(f"   {title}") for t in axes.texts):
            return axes
    raise AssertionError(f"no panel {title!r} in {[a.get_title() for a in figure.axes]}")


def outline_of(text: Text, renderer: object) -> Path:
    """Rectangle of a text in pixels, a hair inside of its box, slanted as it is."""
    turn = text.get_rotation()
    slanted = turn % 90 != 0 and turn % 90 < 89.999
    if slanted:
        text.set_rotation(0)
    box = text.get_window_extent(renderer).padded(-1.5)  # type: ignore[arg-type]
    text.set_rotation(turn)
    low, high = box.min, box.max
    corners = Path([low, (high[0], low[1]), high, (low[0], high[1]), low])
    way = Affine2D().rotate_deg_around(*(low + high) / 2, turn if slanted else 0)
    return corners.transformed(way)


def clashes(figure: Figure) -> list[tuple[str, str]]:
    """Texts that are drawn over each other by more than a hair, or over the edge of the page."""
    drawn = []
    draw = Text.draw

    def record(text: Text, renderer: object) -> None:
        draw(text, renderer)  # type: ignore[arg-type]
        if text.get_visible() and text.get_text().strip():
            drawn.append((text.get_text(), outline_of(text, renderer)))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Text, "draw", record)
        figure.draw_without_rendering()
    assert len(drawn) > 20
    page = figure.bbox.size
    boxes = [(words, box.vertices) for words, box in drawn]
    cut = [(words, "page") for words, at in boxes if (at < 0).any() or (at > page).any()]
    return cut + [
        (one, other)
        for row, (one, box) in enumerate(drawn)
        for other, there in drawn[row + 1 :]
        if box.intersects_path(there, filled=True)
    ]


@pytest.fixture(scope="module")
def drawn() -> tuple[Figure, Estimate, np.ndarray, list[tuple[np.ndarray, float, float]]]:
    estimate, readings, presses = two_presses()
    valid = estimate.valid.copy()
    valid[3] = False
    readings[40] = np.nan
    estimate = replace(estimate, valid=valid)
    return draw_estimate(estimate, readings, truth=presses), estimate, readings, presses


def test_every_axis_names_its_quantity_and_unit(drawn):
    figure = drawn[0]
    words = words_of(figure)
    assert words.count("x (mm)") == words.count("y (mm)") == 3
    assert {"ΔC/C₀ (%)", "pressure (kPa)", "indentation (mm)"} <= set(words)
    assert {"place (mm)", "force (N)", "area (mm²)", "peak (kPa)"} <= set(words)
    for title in ("Pressure", "Raw reading"):
        assert panel(figure, title).get_aspect() == 1.0


def test_pads_carry_the_readings_and_the_left_out_are_crossed(drawn):
    figure, _, readings, _ = drawn
    axes = panel(figure, "Raw reading")
    shown, crossed = [c for c in axes.collections if isinstance(c, EllipseCollection)]
    kept = np.setdiff1d(np.arange(72), [3, 40])
    np.testing.assert_allclose(shown.get_array(), readings[kept] * 100)
    np.testing.assert_allclose(shown.get_widths(), 4.0)
    plane = hexagon_patch().plane * 1e3
    np.testing.assert_allclose(crossed.get_offsets(), plane[[3, 40]])
    assert len(crossed.get_facecolor()) == 0  # hollow
    (crosses,) = [c for c in axes.collections if isinstance(c, LineCollection)]
    assert len(crosses.get_segments()) == 4
    assert "pads to scale; crossed: 2 left out" in words_of(figure)


def test_pressure_is_shown_in_kpa_where_it_is(drawn):
    figure, estimate, _, _ = drawn
    (image,) = panel(figure, "Pressure").images
    np.testing.assert_allclose(
        image.get_array(), estimate.pressure.reshape(estimate.grid.shape) * 1e-3
    )
    half = estimate.grid.pitch / 2
    low, high = estimate.grid.plane.min(axis=0) - half, estimate.grid.plane.max(axis=0) + half
    extent = [low[0], high[0], low[1], high[1]]
    np.testing.assert_allclose(image.get_extent(), np.array(extent) * 1e3)


def test_contacts_and_truth_are_drawn_where_they_are(drawn):
    figure, estimate, _, presses = drawn
    axes = panel(figure, "Pressure")
    circles = [p for p in axes.patches if isinstance(p, Circle)]
    for (position, _, radius), circle in zip(presses, circles, strict=True):
        np.testing.assert_allclose(circle.center, position[:2] * 1e3, atol=1e-9)
        assert circle.radius == pytest.approx(radius * 1e3)
    outlines = [line.get_xydata() for line in axes.lines if len(line.get_xydata()) > 1]
    numbers = {text.get_text(): text.get_position() for text in axes.texts}
    drawn_contacts = zip(estimate.contacts, outlines, strict=True)
    for index, (contact, outline) in enumerate(drawn_contacts, start=1):
        np.testing.assert_allclose(outline, contact.outline[:, :2] * 1e3, atol=1e-9)
        away = np.array(numbers[str(index)]) - contact.position[:2] * 1e3
        assert np.hypot(*away) < 3 * contact.radius * 1e3


def test_the_hatch_covers_what_no_taxel_surrounds(drawn):
    figure, estimate, _, _ = drawn
    grid = estimate.grid
    (hatch,) = [p for p in panel(figure, "Pressure").patches if p.get_hatch()]
    x, y = hatch.get_path().vertices.reshape(-1, 5, 2)[:, :4].transpose(2, 1, 0)
    area = 0.5 * np.abs((x * np.roll(y, -1, axis=0) - y * np.roll(x, -1, axis=0)).sum(axis=0))
    assert area.sum() == pytest.approx((~grid.covered).sum() * grid.cell_area * 1e6)
    inside = hatch.get_path().contains_points(grid.plane[grid.covered] * 1e3)
    assert not inside.any()


def test_the_table_holds_the_numbers(drawn):
    figure, estimate, _, _ = drawn
    words = [t.get_text() for t in panel(figure, "Contacts").texts]
    first, second = estimate.contacts
    assert f"{first.peak_pressure * 1e-3:.1f}" in words
    assert f"{first.normal_force + second.normal_force:.2f}" in words
    assert "8.0, 4.0" in words  # the truth
    assert any(w.startswith("off the truth by −") for w in words)
    assert "whole field 1.45 N; 71 of 72 taxels used" in words
    assert any(w.endswith("40.0 µs") for w in words)


def test_a_flat_surface_shows_its_depth(drawn):
    figure, estimate, _, _ = drawn
    (axes,) = [a for a in figure.axes if a.name == "3d"]
    low, high = axes.get_zlim()
    assert -low == pytest.approx(estimate.indentation.max() * 1e3)
    assert high >= -estimate.indentation.min() * 1e3
    scale = axes.get_box_aspect() / [np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim()), high - low]
    assert scale[1] == pytest.approx(scale[0])
    assert scale[2] == pytest.approx(100 * scale[0])
    assert "indentation drawn 100 times larger" in words_of(figure)


def many_presses() -> tuple[Estimate, list[tuple[np.ndarray, float, float]]]:
    random = np.random.default_rng(1)
    presses = [
        (np.array([*random.uniform(-0.02, 0.02, 2), 0.0]), force, 2e-3)
        for force in random.uniform(0.1, 2.0, 17)
    ]
    return estimate_of(sf.Grid.square(hexagon_patch(), 24), presses), presses


@lru_cache
def curved() -> tuple[Estimate, list[tuple[np.ndarray, float, float]]]:
    patch = sf.layouts.cylinder(radius=0.02, length=0.045, arc_angle=2.2, pitch=5.5e-3)
    grid = sf.Grid.window(patch, [-0.018, -0.018], [0.018, 0.018], 2e-3)
    press = (grid.patch.surface.position_from_plane(np.array([[0.012, 0.004]]))[0], 12.0, 5e-3)
    return estimate_of(grid, [press]), [press]


def array_of(rows: int, columns: int) -> Estimate:
    x, y = np.meshgrid(np.arange(columns) * 5.5e-3, np.arange(rows) * 5.5e-3)
    plane = np.column_stack([x.ravel(), y.ravel()])
    grid = sf.Grid.window(sf.Patch(plane), plane.min(axis=0), plane.max(axis=0), 6e-3)
    return estimate_of(grid, [(grid.positions[len(grid) // 3], 30.0, 12e-3)])


CASES = {
    "two": lambda: two_presses()[::2],
    "many": many_presses,
    "curved": curved,
    "tall": lambda: (array_of(32, 14), None),
    "wide": lambda: (array_of(8, 30), None),
    "none": lambda: (estimate_of(sf.Grid.square(hexagon_patch(), 12), []), None),
}


@pytest.mark.parametrize("case", CASES)
def test_no_words_overlap_or_leave_the_page(case):
    estimate, truth = CASES[case]()
    figure = draw_estimate(estimate, readings_of(estimate), truth=truth)
    assert clashes(figure) == []


def test_more_contacts_than_fit_are_summed():
    estimate, _ = many_presses()
    figure = draw_estimate(estimate)
    words = [t.get_text() for t in panel(figure, "Contacts").texts]
    (others,) = [w for w in words if w.endswith(" others")]
    left = int(others.split()[0])
    assert 0 < left < 17
    rest = sum(c.normal_force for c in estimate.contacts[17 - left :])
    assert float(words[words.index(others) + 1]) == pytest.approx(rest, rel=5e-3)


def test_no_contact_is_said():
    estimate = estimate_of(sf.Grid.square(hexagon_patch(), 20), [])
    words = words_of(draw_estimate(estimate, truth=[((0.0, 0.0), 1.0, 3e-3)]))
    assert "no contact above the noise" in words
    assert "truth: no contact found" in words
    assert "palm: no contact" in words


def test_without_readings_the_residual_is_shown():
    estimate, _, _ = two_presses()
    axes = panel(draw_estimate(estimate, quantity_unit="1"), "Residual")
    pads = next(c for c in axes.collections if isinstance(c, EllipseCollection))
    np.testing.assert_allclose(pads.get_array(), estimate.residual)


def test_a_curved_patch_is_drawn_in_space_moved_along_its_normals():
    estimate, truth = curved()
    grid = estimate.grid
    figure = draw_estimate(estimate, readings_of(estimate), truth=truth)
    (axes,) = [a for a in figure.axes if a.name == "3d"]
    note = next(w for w in words_of(figure) if w.startswith("indentation drawn"))
    factor = float(note.split()[2])
    moved = (grid.positions + factor * estimate.displacement) * 1e3
    limits = np.array([axes.get_xlim(), axes.get_ylim(), axes.get_zlim()])
    np.testing.assert_allclose(limits[:, 0], moved.min(axis=0), atol=1e-9)
    np.testing.assert_allclose(limits[:, 1], moved.max(axis=0), atol=1e-9)
    (circle,) = [p for p in panel(figure, "Pressure").patches if isinstance(p, Circle)]
    np.testing.assert_allclose(circle.center, [12.0, 4.0], atol=0.05)  # along the skin
    assert "u along the skin (mm)" in words_of(figure)


def test_all_taxels_invalid_and_odd_names_are_drawn():
    estimate, readings, _ = two_presses()
    patch = replace(estimate.grid.patch, name="left $arm_1$ \\frac{")
    estimate = replace(estimate, grid=replace(estimate.grid, patch=patch))
    figure = draw_estimate(estimate, readings * np.nan)
    figure.draw_without_rendering()
    assert "pads to scale; crossed: 72 left out" in words_of(figure)
    assert "ΔC/C₀ (%)" not in words_of(figure)  # no colour, no bar


def test_a_square_grid_over_a_long_patch_is_cut_to_the_patch():
    plane = array_of(8, 30).grid.patch.plane
    grid = sf.Grid.square(sf.Patch(plane), 40)
    figure = draw_estimate(estimate_of(grid, [(grid.positions[820], 30.0, 12e-3)]))
    low, high = plane.min(axis=0) * 1e3, plane.max(axis=0) * 1e3
    for title in ("Pressure", "Residual"):
        bottom, top = panel(figure, title).get_ylim()
        assert low[1] - 8 < bottom < low[1] - 2
        assert high[1] + 2 < top < high[1] + 8
    (axes,) = [a for a in figure.axes if a.name == "3d"]
    assert np.ptp(axes.get_ylim()) < high[1] - low[1] + grid.pitch * 2e3
    assert figure.get_figheight() < 5.5  # no empty rows on the page


@pytest.mark.parametrize("shape", [(1, 1), (1, 3), (2, 2)])
@pytest.mark.parametrize("taxels", [1, 2])
def test_tiny_grids_are_drawn(taxels, shape):
    patch = sf.Patch(np.array([[0.0, 0.0], [5e-3, 0.0]])[:taxels])
    grid = sf.Grid(patch, shape, 3e-3)
    estimate = estimate_of(grid, [(np.zeros(3), 1.0, 5e-3)])
    draw_estimate(estimate, [0.1, 0.2][:taxels]).draw_without_rendering()


def test_a_batch_is_refused_and_the_highest_load_is_named():
    estimate, readings, _ = two_presses()
    names = ("pressure", "traction", "displacement", "pressure_std", "residual", "valid")
    names += ("readings", "readings_std")
    fields = {name: np.stack([getattr(estimate, name)] * 3) for name in names}
    fields["pressure"][1] *= 3
    batch = replace(estimate, contacts=(estimate.contacts,) * 3, **fields)
    with pytest.raises(InputError, match=r"3 readings, expected one.*estimate\[1\]"):
        draw_estimate(batch, readings)
    draw_estimate(batch[1], readings)


@pytest.mark.parametrize(
    ("truth", "words"),
    [
        (3, r"truth\[0\] is 3"),
        ((np.zeros(4), 1.0, 1e-3), r"truth\[0\] is .*position has shape \(4,\), expected"),
        ((np.zeros(3), np.nan, 1e-3), r"truth\[0\]\[3\] is nan"),
    ],
)
def test_wrong_readings_and_truths_are_refused(truth, words):
    estimate, readings, _ = two_presses()
    with pytest.raises(InputError, match=words):
        draw_estimate(estimate, readings, truth=[truth])
    with pytest.raises(InputError, match=r"readings has shape \(71,\), expected \(72\)"):
        draw_estimate(estimate, readings[:-1])


@given(st.integers(0, 2**32 - 1))
def test_the_plane_is_found_again_from_space(seed):
    random = np.random.default_rng(seed)
    tilt, _ = np.linalg.qr(random.normal(size=(3, 3)))
    corners = np.array([[0, 0], [0.03, 0], [0, 0.02], [0.03, 0.02]]) @ tilt[:, :2].T
    patch = sf.Patch(corners + random.normal(size=3), normals=np.tile(tilt[:, 2], (4, 1)))
    grid = sf.Grid.square(patch, 7)
    plane = grid.plane[5] + random.uniform(-0.05, 0.05, (4, 2))
    back = Chart(grid).plane_from_position(patch.surface.position_from_plane(plane))
    np.testing.assert_allclose(back, plane, atol=1e-12)


def test_a_picture_is_written_the_same_twice(tmp_path):
    grid = sf.Grid.square(sf.layouts.icub_triangle(), 6)
    estimate = estimate_of(grid, [(grid.positions[14], 1.0, 5e-3)])
    figures = [draw_estimate(estimate, readings_of(estimate)) for _ in range(2)]
    for ending in ("png", "pdf", "svg"):
        one, other = (plot.save(each, tmp_path / f"a.{ending}").read_bytes() for each in figures)
        assert one == other
        assert b"CreationDate" not in one
        assert b"dc:date" not in one


def test_the_extension_chooses_the_format_and_others_are_refused(tmp_path):
    figure = draw_timeline(np.arange(9.0), np.arange(9.0), np.ones(9))
    heads = {"png": b"\x89PNG", "PNG": b"\x89PNG", "jpg": b"\xff\xd8", "jpeg": b"\xff\xd8"}
    for ending, head in {**heads, "pdf": b"%PDF", "svg": b"<?xml"}.items():
        content = plot.save(figure, tmp_path / f"map.{ending}", dpi=50).read_bytes()
        assert content.startswith(head)
        if ending == "png":
            assert np.frombuffer(content[16:24], ">u4").tolist() == [500, 250]
    for name in ("a.bmp", "a", "a.png.gz"):
        with pytest.raises(InputError, match=r"expected one of \.png, \.pdf, \.svg"):
            plot.save(figure, tmp_path / name)
    with pytest.raises(FileError, match=r"cannot be written: .*No such file or directory"):
        plot.save(figure, tmp_path / "nowhere" / "a.png")
    with pytest.raises(InputError, match="dpi is -1"):
        plot.save(figure, tmp_path / "a.png", dpi=-1)


def test_white_is_zero_and_darker_is_more():
    colours, scale = signed_colours(np.array([-2.0, 5.0, np.nan]))
    assert (scale.vmin, scale.vmax) == (-2.0, 5.0)
    level = np.linspace(-2, 5, 300)
    grey = colours(scale(level))[:, :3] @ [0.2126, 0.7152, 0.0722]
    assert grey[np.abs(level).argmin()] > 0.94
    assert (np.diff(grey[level > 0.05]) <= 1e-9).all()
    assert (np.diff(grey[level < -0.05]) >= -1e-9).all()
    assert colours(scale(np.array(-1.0)))[2] > colours(scale(np.array(-1.0)))[0]  # blue below


def test_numbers_have_three_digits_and_a_spread_sets_them():
    values = (0.0, 1.0234, -12.34, 123.4, 12345.0, 0.01234, np.nan)
    written = ["0", "1.02", "−12.3", "123", "12345", "0.0123", "–"]
    assert [number(value) for value in values] == written
    pairs = [(1.02, 0.03), (12.3, 0.4), (1.5, np.nan), (100.0, 20.0), (1.0, 1e-9), (1.0, 0.0)]
    written = ["1.02 ± 0.03", "12.3 ± 0.4", "1.50", "100 ± 20", "1.000 ± 0.000", "1.00"]
    assert [plus_minus(*pair) for pair in pairs] == written
    times = [duration(value) for value in (0.0, 2.34e-6, 20e-6, 1.5e-3, 9.9996e-4, 0.73, 1.25)]
    assert times == ["0 µs", "2.34 µs", "20.0 µs", "1.50 ms", "1.00 ms", "730 ms", "1.25 s"]


def test_a_timeline_states_its_difference():
    time = np.linspace(0, 10, 201)
    force = 10 + np.sin(time)
    force[7] = np.nan
    reference = np.where(time <= 9, 2 * time, np.nan)  # ends before the skin
    figure = draw_timeline(time, force, reference, label="foot")
    difference = (force - reference)[np.isfinite(force - reference)]
    mean, rms = difference.mean(), np.sqrt((difference**2).mean())
    np.testing.assert_array_equal(figure.axes[1].lines[0].get_ydata(), force - reference)
    words = [*words_of(figure), figure.axes[1].get_title(loc="left")]
    assert f"foot − reference: mean {mean:.2f} N, root mean square {rms:.2f} N" in words
    assert {"normal force (N)", "difference (N)", "time (s)"} <= set(words)
    assert clashes(figure) == []
    apart = draw_timeline(time, force, np.full(201, np.nan))
    assert apart.axes[1].get_title(loc="left") == "nothing in common with the reference"


def test_timelines_of_unequal_length_are_refused():
    with pytest.raises(InputError, match=r"force_N has shape \(3,\), expected \(4\)"):
        draw_timeline(np.arange(4.0), np.arange(3.0), np.arange(4.0))
    with pytest.raises(InputError, match=r"reference has shape \(3,\)"):
        draw_timeline(np.arange(4.0), np.arange(4.0), np.arange(3.0))
    with pytest.raises(InputError, match=r"time_s\[1\] is nan"):
        draw_timeline([0.0, np.nan], np.arange(2.0), np.arange(2.0))


def test_drawing_leaves_the_callers_settings_and_loads_no_display():
    code = (
        "import sys, skinfield.signal.plot\n"
        "assert 'matplotlib' not in sys.modules\n"
        "import matplotlib; before = matplotlib.rcParams.copy()\n"
        "skinfield.signal.plot.draw_timeline([0, 1], [1, 2], [1, 1])\n"
        "assert matplotlib.rcParams.copy() == before\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=300)


# ---- presses

LAYER = sf.Layer(2e-3, 100e3)


@pytest.fixture(scope="module")
def two() -> Press:
    bodies = [
        Sphere(radius=6e-3, position=(-6e-3, 2e-3), force=1.0),
        Ring(inner_radius=3e-3, outer_radius=5e-3, position=(7e-3, 0.0), force=0.5),
    ]
    return press(LAYER, bodies, extent=40e-3, cell=0.5e-3)


def test_panels_and_section_of_a_press_have_the_true_numbers(two: Press) -> None:
    figure = draw_press(two)
    words = " ".join(words_of(figure))
    assert "ball 1.00 N, ring 0.500 N on 2.00 mm of 100 kPa" in words
    assert f"contact {two.contact_area * 1e6:.1f} mm²" in words
    for label in ("pressure (kPa)", "base stress (kPa)", "indentation (mm)", "x (mm)", "y (mm)"):
        assert label in words
    image = figure.axes[0].images[0]
    assert image.get_array().max() == pytest.approx(two.pressure.max() / 1e3)
    low, high = figure.axes[0].get_xlim()
    touched = two.grid.plane[two.contact, 0] * 1e3
    assert low < touched.min() < touched.max() < high
    assert "at y = 1.75 mm" in words or "at y = 2.25 mm" in words  # of the strongest body
    section = next(axes for axes in figure.axes if "height over" in axes.get_ylabel())
    surface = section.lines[0].get_ydata()
    row = np.abs(two.grid.plane[:, 1] - 2e-3) < 0.3e-3
    assert -surface.min() == pytest.approx(-two.displacement[row, 2].min() * 1e3, rel=0.02)


def test_taxels_are_shown_with_their_readings(two: Press) -> None:
    patch = sf.layouts.hexagon72()
    figure = draw_press(two, patch)
    assert any("72 taxels" in words for words in words_of(figure))
    assert "ΔC/C₀ (%)" in words_of(figure)
    stress = two.base_stress(patch.plane, patch.pad_diameter) / 1e3
    other = draw_press(two, patch, stress, label="base stress (kPa)")
    assert "base stress (kPa)" in words_of(other)
    with pytest.raises(InputError, match=r"readings has shape \(3,\)"):
        draw_press(two, patch, np.zeros(3))


def test_many_bodies_have_a_heading_that_fits(tmp_path) -> None:
    places = np.stack(np.meshgrid(np.arange(3), np.arange(3)), -1).reshape(-1, 2) * 9e-3 - 9e-3
    bodies = [Cylinder(radius=2e-3, position=(x, y), force=0.1) for x, y in places.tolist()]
    found = press(LAYER, bodies, extent=36e-3, cell=0.6e-3)
    assert heading(found) == "9 indenters, 0.900 N on 2.00 mm of 100 kPa"
    figure = draw_press(found)
    plot.save(figure, tmp_path / "many.png")
    title = figure.texts[0].get_window_extent()
    assert title.x1 < figure.bbox.x1
