"""Images of stamps that move: overlap with the truth, outline, force, motion, time.

  python benchmarks/contact_images.py                all stamps, poses given and found
  python benchmarks/contact_images.py --runs 5 key   one of them, more often

Stamps are flat, of strokes of 4 mm, pressed with 5 N on 72 taxels whose readings have a noise of
0.002 in ΔC/C₀. Truth is the simulator's own press, all of whose face touches. The weights of
`skinfield.reconstruct.contact_image_fit` were chosen by L, T, F and V, none of these. Poses that
are given are anywhere within one pitch; those that are found go a round way as wide, and turn by
15 degrees to and fro. Time is that of the process, which neighbours on the same core lengthen.
"""

import time
from typing import Any

import click
import numpy as np
from matplotlib.path import Path as Polygon
from scipy.ndimage import distance_transform_edt

import skinfield as sf
from skinfield.errors import Floats
from skinfield.estimate.contact_image import ContactImage
from skinfield.simulate import HeightMap
from skinfield.simulate.pressing.press import readings_anywhere

PIXEL, STEP, FORCE, NOISE = 0.2e-3, 0.1e-3, 5.0, 0.002  # m, m, N, ΔC/C₀
MARKS = 1, 10, 30
PATCH, LAYER = sf.layouts.hexagon72(), sf.Layer()
AXIS = np.arange(-13e-3, 13e-3, STEP)


def faces() -> dict[str, Any]:
    """Where each stamp is, on a lattice of pixels."""
    axis = (np.arange(110) - 54.5) * PIXEL * 1e3
    x, y = np.meshgrid(axis, axis)
    radius, angle = np.hypot(x, y), np.degrees(np.arctan2(y, x)) % 360

    def box(left: float, low: float, right: float, high: float) -> Any:
        return (x > left) & (x < right) & (y > low) & (y < high)

    def line(ax: float, ay: float, bx: float, by: float) -> Any:
        along = ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2)
        along = np.clip(along, 0, 1)
        return np.hypot(x - ax - along * (bx - ax), y - ay - along * (by - ay)) < 2

    def bow(middle: float, start: float, end: float, size: float) -> Any:
        turn = np.degrees(np.arctan2(y - middle, x)) % 360
        return (abs(np.hypot(x, y - middle) - size) < 2) & ((turn - start) % 360 < end - start)

    head = np.hypot(x + 5, y)
    return {
        "C": (abs(radius - 6.5) < 2) & (abs(angle - 180) < 135),
        "ring": abs(radius - 6) < 2,
        "bar": box(-9, -2, 9, 2),
        "key": (head < 4.5) & (head > 1.5) | box(-1.5, -2, 9.5, 2) | box(5.5, -5.5, 9.5, 0),
        "U": box(-7, -3, -3, 8) | box(3, -3, 7, 8) | (abs(np.hypot(x, y + 2) - 5) < 2) & (y < -2),
        "S": bow(4.2, 0, 270, 4.2) | bow(-4.2, 180, 450, 4.2),
        "X": line(-6, 7, 6, -7) | line(6, 7, -6, -7),
        "H": box(-8, -8, -4, 8) | box(4, -8, 8, 8) | box(-8, -2, 8, 2),
        "J": box(2, -8, 6, 8) | box(-6, -8, 6, -4) | box(-6, -8, -2, -1),
    }


def turned(angle: float) -> Floats:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])


def scores(image: ContactImage, stamp: HeightMap, pose: Floats) -> tuple[float, float, float]:
    """Overlap on the skin, mean distance of the outlines in mm, and force over the true one."""
    x, y = np.meshgrid(AXIS + pose[0], AXIS + pose[1])
    points = np.column_stack([x.ravel(), y.ravel()])
    inside = sum(Polygon(each[:, :2]).contains_points(points).astype(int) for each in image.outline)
    found = (np.asarray(inside) % 2 == 1).reshape(x.shape)
    true = np.isfinite(stamp.height(*((points - pose[:2]) @ turned(pose[2])).T)).reshape(x.shape)
    borders = [each ^ np.roll(each, 1, 0) | each ^ np.roll(each, 1, 1) for each in (found, true)]
    if not borders[0].any():
        return 0.0, np.inf, image.force / FORCE
    away = [distance_transform_edt(~each) * STEP * 1e3 for each in borders]
    distance = (away[1][borders[0]].mean() + away[0][borders[1]].mean()) / 2
    return float((found & true).sum() / (found | true).sum()), distance, image.force / FORCE


def way(given: bool, rng: np.random.Generator) -> Floats:
    """Poses (30, 3) m, m, rad."""
    start = rng.uniform(0, 2 * np.pi, 3)
    if given:
        places = rng.uniform(-1, 1, (MARKS[-1], 2)) * PATCH.pitch / 2
        return np.column_stack([places, np.full(MARKS[-1], start[2])])
    t = np.arange(MARKS[-1]) / MARKS[-1] * 2 * np.pi
    wide = PATCH.pitch / 2 * np.column_stack([np.sin(t + start[0]), np.cos(t + start[0])])
    return np.column_stack([wide, start[2] + np.radians(15) * np.sin(t + start[1])])


def motion_error(found: Floats, true: Floats) -> tuple[float, float]:
    """Mean errors in mm and degrees of the motion, whatever the body's frame."""
    turn = np.angle(np.mean(np.exp(1j * (true[:, 2] - found[:, 2]))))
    shift = np.mean(
        [turned(-f[2]) @ (t[:2] - f[:2]) for f, t in zip(found, true, strict=True)], axis=0
    )
    places = [
        np.hypot(*(f[:2] + turned(f[2]) @ shift - t[:2])) for f, t in zip(found, true, strict=True)
    ]
    off = (found[:, 2] + turn - true[:, 2] + np.pi) % (2 * np.pi) - np.pi
    return float(np.mean(places)) * 1e3, float(np.degrees(np.abs(off).mean()))


def run(rec: Any, stamp: HeightMap, clean: Any, given: bool, seed: int) -> list[float]:
    """Scores after 1, 10 and 30 readings, errors of the motion, and ms an update."""
    rng = np.random.default_rng(seed)
    images, poses = sf.ContactImages(rec), way(given, rng)
    out: list[float] = []
    found, spent = [], []
    for count, pose in enumerate(poses, start=1):
        readings = clean((PATCH.plane - pose[:2]) @ turned(pose[2]))
        readings += rng.normal(scale=NOISE, size=len(PATCH))
        start = time.process_time()
        images.update(readings, poses=pose if given else None)
        spent.append(time.process_time() - start)
        found.append(images.images[0].pose if images.images else np.full(3, np.nan))
        if count in MARKS:
            out += scores(images.images[0], stamp, pose) if images.images else (0.0, np.inf, 0.0)
    late = slice(MARKS[1], None)  # as the live loop has them: each when it came
    return [*out, *motion_error(np.array(found)[late], poses[late]), 1e3 * np.median(spent[late])]


@click.command()
@click.option("--runs", default=3)
@click.argument("names", nargs=-1)
def main(runs: int, names: tuple[str, ...]) -> None:
    """Print the tables."""
    rec = sf.Reconstructor(PATCH, LAYER, solver=sf.Tikhonov(), noise_std=NOISE)
    for given in (True, False):
        print(f"\nposes {'given' if given else 'found'}: overlap, outline (mm), force ratio after")
        print(f"{'':6}" + "".join(f"{f'{mark} readings':^19}" for mark in MARKS) + "  mm   °   ms")
        rows = []
        for name, face in faces().items():
            if names and name not in names:
                continue
            stamp = HeightMap(heights=np.where(face, 0.0, np.nan), pixel=PIXEL, force=FORCE)
            press = sf.simulate.press(LAYER, [stamp], extent=26e-3, cell=0.25e-3)
            clean = readings_anywhere(press, PATCH.pad_diameter, "capacitance", 0.5e-3)
            each = [run(rec, stamp, clean, given, seed) for seed in range(runs)]
            rows += each
            show(name, np.median(each, axis=0))
        show("median", np.median(rows, axis=0))
        last = np.array(rows)[:, 6]
        print(f"overlap after 30: {np.mean(last > 0.7):.0%} above 0.7, lowest {last.min():.2f}")


def show(name: str, row: Floats) -> None:
    """One line of a table."""
    parts = [f"{row[k]:6.2f}{row[k + 1]:6.2f}{row[k + 2]:6.2f} " for k in (0, 3, 6)]
    print(f"{name:6}" + "".join(parts) + f"{row[9]:6.2f}{row[10]:5.1f}{row[11]:5.1f}", flush=True)


if __name__ == "__main__":
    main()
