"""`skinfield demo`: the main job with nothing at hand."""

import os
import time
import timeit
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter

from skinfield.cli import options, report
from skinfield.cli.report import Column
from skinfield.cli.settings import Elastomer, ModelSettings
from skinfield.errors import Floats, InputError, as_floats

if TYPE_CHECKING:
    from skinfield import Estimate, Reconstructor
    from skinfield.estimate.contact_image import ContactImage
    from skinfield.reconstruct.serialisation import ReconstructorConfig
    from skinfield.simulate import HeightMap, Press, Sphere

DEFAULT_PRESSES = ("13,-12,3,10", "-16,8,2,6")  # mm, mm, N, mm
PICTURE = "demo.png"
COLD = "latency: measured once compiled; run it again"
INTERPRETED = (
    f"{COLD} in about a minute. Nothing is compiled on this machine yet: that has begun in the "
    "background (`skinfield warmup`), and a reading then takes less than a millisecond"
)
FAR = 8e-3  # m: a contact beyond is not of this press
STAMP = (  # strokes of the letter R: from, to, in mm
    ((-4, -7), (-4, 7)), ((-4, 7), (2, 7)), ((4, 5), (4, 2)), ((2, 7), (4, 5)), ((4, 2), (2, 0)),
    ((2, 0), (-4, 0)), ((0, 0), (5, -7)),
)  # fmt: skip
STROKE, PIXEL, STAMP_FORCE = 4e-3, 0.2e-3, 5.0  # m, m, N
SHOWN = 1, 10, 30  # readings of which an image is shown
SHARPENING = (
    Column("readings", "readings", decimals=0), Column("overlap", "overlap", decimals=2),
    Column("area mm²", "area_m2", 1e6, 0), Column("true mm²", "true_area_m2", 1e6, 0),
    Column("force N", "force_N", decimals=2), Column("true N", "true_force_N", decimals=2),
)  # fmt: skip
AGAINST = (
    Column("press", "press", decimals=0), Column("true N", "force_N", decimals=2),
    Column("found N", "estimated_force_N", decimals=2),
    Column("± N", "estimated_force_std_N", decimals=2),
    Column("force error %", "force_error", 100.0, 0),
    Column("place error mm", "place_error_m", 1e3, 2),
)  # fmt: skip


def demo(
    what: Literal["balls", "shape"] = "balls",
    /,
    *,
    layout: options.LayoutText = "hexagon72",
    press: Annotated[tuple[str, ...], Parameter(allow_leading_hyphen=True)] = (),
    noise: options.Noise = None,
    seed: options.Seed = 0,
    output: Annotated[str | None, options.OUTPUT] = None,
    force: options.Force = False,
    as_json: options.Json = False,
    elastomer: options.OfElastomer = Elastomer(),
    model: options.Model = ModelSettings(),
) -> None:
    """Simulate rigid balls that press on a patch, reconstruct what they do, and compare.

    The truth comes from a contact solver on a finer grid of its own and, for capacitance, from the
    nonlinear electrostatics of the pads; the reconstruction sees noisy readings only. Or a stamp,
    the letter R, that is moved over the patch within a pitch: its image after 1, 10, 30 readings.

      skinfield demo
      skinfield demo shape
      skinfield demo --press 0,6,2,6 --solver nonnegative
      skinfield demo --press 0,6,2,6 --solver tikhonov --grid 20 -o demo.pdf
      skinfield demo --quantity stress --mechanics half-space --solver inverse

    Parameters
    ----------
    what : str
        What presses: balls, or a stamp whose shape is found.
    press : tuple of str
        A ball, X,Y,F,R: place mm, force N, radius mm; again for more.
    output : str, optional
        Figure to write: .png, .pdf or .svg. Default demo.png, or a name that is free.
    """
    from skinfield.compiled import CONFIG, MODE

    picture = output
    if output is None:
        picture = report.picture_if_drawable(report.free_name(PICTURE))
    report.check_picture("--output", picture, force)
    name = model.quantity or "capacitance"
    config = _config_of(layout, noise, elastomer, replace(model, quantity=name))
    is_first = MODE.interpreted and not CONFIG.DISABLE_JIT
    balls = [options.parsed("--press", text, _ball_of) for text in press or DEFAULT_PRESSES]
    if what == "shape":
        _shape(config, name, seed, picture, as_json)
        return
    with report.compilation(quiet=as_json) as compiling:
        true, readings = _pressed(config, balls, name, seed)
        start = time.perf_counter()
        reconstructor = config.reconstructor()
        prepared = time.perf_counter() - start
        estimate = reconstructor(readings)
    own = not (is_first or compiling.count)  # else times are those of the interpreter, the compiler
    truth = [(b.position, b.force, r) for b, r in zip(balls, _radii(true, balls), strict=True)]
    if picture is not None:
        report.save_picture(picture, estimate, readings, config, truth, note="" if own else COLD)
    report.say_notes(estimate.notes)
    rows = [_against(index, ball, estimate) for index, ball in enumerate(balls, start=1)]
    result = _plain(estimate, prepared if own else None) | {"presses": rows, "picture": picture}

    def lines() -> Iterator[report.Shown]:
        yield report.table_of_contacts(estimate.contacts, f"Contacts, by {estimate.solver}")
        yield report.table_of("Against the known truth (–: missed)", rows, AGAINST)
        yield _total(balls, estimate)
        if is_first:
            yield INTERPRETED
            return
        yield _latency(reconstructor, readings, estimate, prepared if own else None)

    report.finish(as_json, result, [picture], lines())
    if is_first:
        _compile_in_background()


def _config_of(
    layout: str, noise: float | None, elastomer: Elastomer, model: ModelSettings
) -> "ReconstructorConfig":
    """Settings of a reconstruction of the layout's patch, by the profile in use."""
    patch = options.patch_of(options.skin_from_text(layout), None)
    profile = options.profile_in_use(elastomer, layout=layout)
    layer, quantity = options.layer_of(elastomer, profile), options.quantity_of(str(model.quantity))
    spread = quantity.typical_noise if noise is None else noise
    return options.config_of(patch, layer, quantity, spread, options.filled(model, profile))


def _pressed(
    config: "ReconstructorConfig", balls: list["Sphere"], name: str, seed: int
) -> "tuple[Press, Floats]":
    """What balls truly do to the layer, on a grid of its own, and noisy readings of it."""
    from skinfield.simulate import press

    patch, spread = config.patch, np.asarray(config.noise_std, np.float64)
    extent = 2 * float(np.abs(patch.plane).max()) + 12e-3
    true = press(config.layer, balls, extent=extent, cell=min(0.4e-3, extent / 40))
    noise = np.random.default_rng(seed).normal(scale=spread, size=len(patch))
    return true, true.readings(patch.plane, patch.pad_diameter, name) + noise


def _plain(estimate: "Estimate", prepared: float | None) -> dict[str, Any]:
    """What was found, and how long it took; not known where anything was compiled meanwhile."""
    return {
        "contacts": report.plain_contacts(estimate.contacts),
        "solver": estimate.solver,
        "prepared_s": prepared,
        "latency_s": None if prepared is None else estimate.latency,
    }


def _shape(
    config: "ReconstructorConfig", quantity: str, seed: int, picture: str | None, as_json: bool
) -> None:
    """Image of a stamp that is moved over the patch within a pitch, as the readings come in."""
    import skinfield as sf
    from skinfield.simulate.pressing.press import readings_anywhere

    patch = config.patch
    with report.compilation(quiet=as_json):
        stamp = _stamp()
        true = sf.simulate.press(config.layer, [stamp], extent=26e-3, cell=0.25e-3)
        clean = readings_anywhere(true, patch.pad_diameter, quantity, spacing=0.5e-3)
        images = sf.ContactImages(config.reconstructor())
        rng, shown = np.random.default_rng(seed), []
        for count, pose in enumerate(_path(SHOWN[-1], patch.pitch), start=1):
            cos, sin = np.cos(pose[2]), np.sin(pose[2])
            places = (patch.plane - pose[:2]) @ np.array([[cos, -sin], [sin, cos]])
            noise = rng.normal(scale=np.asarray(config.noise_std), size=len(patch))
            images.update(clean(places) + noise, poses=pose)
            if count in SHOWN and images.images:
                shown.append(images.images[0])
    area = true.contact_area
    rows = [
        {"readings": each.readings, "overlap": _overlap(each, stamp), "area_m2": each.area,
         "true_area_m2": area, "force_N": each.force, "true_force_N": true.force}
        for each in shown
    ]  # fmt: skip
    if picture is not None:
        _draw_images(shown, true.outline, picture)
    lines = [report.table_of("A stamp, moved within a pitch of the taxels", rows, SHARPENING)]
    report.finish(as_json, {"images": rows, "picture": picture}, [picture], iter(lines))


def _stamp() -> "HeightMap":
    """The letter R of flat strokes."""
    from skinfield.simulate import HeightMap

    axis = np.arange(-11e-3, 11e-3, PIXEL) + PIXEL / 2
    x, y = np.meshgrid(axis, axis)
    inside = np.zeros(x.shape, np.bool_)
    for start, end in STAMP:
        (ax, ay), (bx, by) = np.multiply(start, 1e-3), np.multiply(end, 1e-3)
        along = ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2)
        along = np.clip(along, 0.0, 1.0)
        away = np.hypot(x - ax - along * (bx - ax), y - ay - along * (by - ay))
        inside |= away <= STROKE / 2
    heights = np.where(inside, 0.0, np.nan)
    return HeightMap(heights=heights, pixel=PIXEL, force=STAMP_FORCE)


def _path(count: int, pitch: float) -> Floats:
    """Poses (count, 3) of a body that sways over a pitch, and turns a little to and fro."""
    turn = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
    places = pitch / 2 * np.column_stack([np.cos(2 * turn), np.sin(3 * turn)])
    return np.column_stack([places, 0.3 + 0.2 * np.sin(turn)])


def _overlap(image: "ContactImage", stamp: "HeightMap") -> float:
    """Intersection of outline and stamp over their union."""
    from scipy.interpolate import RegularGridInterpolator

    axis = np.arange(-13e-3, 13e-3, PIXEL) + PIXEL / 2
    x, y = np.meshgrid(axis, axis)
    rows, columns = image.body_positions[:, 0, 1], image.body_positions[0, :, 0]
    pressure = RegularGridInterpolator((rows, columns), image.pressure, "linear", False, 0.0)
    found, true = pressure((y, x)) >= image.level, np.isfinite(stamp.height(x, y))
    return float((found & true).sum() / (found | true).sum())


def _draw_images(images: list["ContactImage"], outline: list[Floats], path: str) -> None:
    """Draw images beside each other, with the true outline."""
    from skinfield.plot import BLUE, new_figure, save, style

    with style():
        figure = new_figure(4.6 * len(images), 4.4)
        for axes, image in zip(figure.subplots(1, len(images)), images, strict=True):
            image.plot(axes)
            for line in outline:
                axes.plot(*line.T * 1e3, color=BLUE, lw=1.2, ls=(0, (3, 2)))
        figure.subplots_adjust(0.05, 0.12, 0.93, 0.86, 0.42)
        figure.axes[0].annotate("dashed: truth", (0.98, 0.02), xycoords="axes fraction",
                                ha="right", color=BLUE, fontsize=8)  # fmt: skip
        save(figure, path)


def _latency(
    reconstructor: "Reconstructor",
    readings: Floats,
    estimate: "Estimate",
    prepared: float | None,
) -> str:
    """What a reading takes the first time, unless something was compiled, and the next times."""
    from skinfield.plot import duration

    later = np.median(timeit.repeat(lambda: reconstructor(readings), number=1, repeat=20))
    first, once = "", "compiled once for this machine"
    if prepared is not None:
        first, once = f"{duration(estimate.latency)}, ", f"prepared once in {prepared:.1f} s"
    nodes = " x ".join(map(str, estimate.grid.shape))
    return f"latency: {first}{duration(float(later))} the next time, at {nodes} nodes; {once}"


def _compile_in_background() -> None:
    """Have all be compiled for this machine, unless that has begun before."""
    from skinfield.compile_progress import is_compiled, known_times
    from skinfield.processes import start_python

    if not is_compiled(known_times().uses["run"][0]):
        with Path(os.devnull).open("wb") as nowhere:
            start_python("skinfield", "warmup", "--json", stderr=nowhere)


def _ball_of(text: str) -> "Sphere":
    from skinfield.simulate import Sphere

    parts = text.split(",")
    if len(parts) != 4:
        raise InputError("expected x,y,force,radius in mm, mm, N, mm")
    x, y, force, radius = as_floats("it", parts).tolist()
    return Sphere(position=(x * 1e-3, y * 1e-3), force=force, radius=radius * 1e-3)


def _radii(true: "Press", balls: list["Sphere"]) -> list[float]:
    """Radius of the circle that has the area of each ball's contact, m."""
    cells = true.grid.plane[true.contact]
    apart = [np.linalg.norm(cells - ball.position, axis=1) for ball in balls]
    counts = np.bincount(np.argmin(apart, axis=0), minlength=len(balls))
    return np.sqrt(counts / np.pi * true.grid.pitch**2).tolist()  # type: ignore[no-any-return]


def _against(index: int, ball: "Sphere", estimate: "Estimate") -> dict[str, Any]:
    """A press beside the contact that is nearest to it, if one is near."""
    near = [(float(np.hypot(*(c.position[:2] - ball.position))), c) for c in estimate.contacts]
    row: dict[str, Any] = {"press": index, "force_N": ball.force}
    place, contact = min(near, key=lambda each: each[0], default=(np.inf, None))
    if contact is None or place > FAR:
        return row | {"missed": True}
    force = contact.normal_force
    error = force / ball.force - 1
    found = {"estimated_force_N": force, "estimated_force_std_N": contact.force_std}
    return row | found | {"force_error": error, "place_error_m": place}


def _total(balls: list["Sphere"], estimate: "Estimate") -> str:
    """Sum of what was found beside the true one; contacts err independently."""
    found = sum(each.normal_force for each in estimate.contacts)
    spread = sum((each.force_std or 0.0) ** 2 for each in estimate.contacts) ** 0.5
    true = sum(ball.force or 0.0 for ball in balls)
    doubt = f" ± {spread:.2f}" if spread else ""
    return f"total: {found:.2f}{doubt} N found, {true:.2f} N true"
