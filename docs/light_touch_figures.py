"""Make the pictures of light-touch.md, and print the numbers that it quotes.

python docs/light_touch_figures.py [smoke|short|full]
"""

import sys
import time
from pathlib import Path

import click
import numpy as np

import skinfield as sf
from skinfield.errors import Floats
from skinfield.lab.report import Settings, size_by_name
from skinfield.lab.sections.detection import Trial
from skinfield.lab.sections.light_touch import light_touch

IMAGES = Path(__file__).parent / "images"
LAYER = sf.Layer(thickness=2e-3, young_modulus=100e3, poisson_ratio=0.5)
NOISE, COUNT = 3.8e3, 40_000  # Pa; idle decisions


def rates(size: str) -> None:
    """Draw ROC curves, and print the tables."""
    section = light_touch(Settings(size=size_by_name(size)))
    for picture in section.pictures:
        (IMAGES / f"light-touch-{picture.name}.png").write_bytes(picture.png)
    for table in section.tables:
        if table.on_page:
            click.echo(f"\n{table.columns}")
            for row in table.rows:
                click.echo(row)


def traps() -> None:
    """Print what noise that is not as stated does to the rate of false alarms, 1e-3."""
    patch, rng = sf.layouts.hexagon72(), np.random.default_rng(3)
    quantity = sf.BaseStress()
    plain, free, half = (
        sf.Detector(patch, LAYER, quantity=quantity, noise_std=NOISE, common_mode=mode)
        for mode in (False, True, NOISE / 2)
    )
    white = rng.normal(scale=NOISE, size=(COUNT, 72))
    offset = rng.normal(scale=NOISE, size=(COUNT, 1))

    def alarms(detector: sf.Detector, readings: Floats, count: int = 1) -> float:
        found = detector.statistics(readings, count) > detector.threshold
        return float(found.mean())

    click.echo("\nfalse alarms per 1000, and 0.1 N over a taxel found in 15 readings")
    light = Trial("over a taxel", 0.1).clean(Settings(), 4000, 40, 9)
    pressed = light + rng.normal(scale=NOISE / np.sqrt(15), size=light.shape)
    for name, detector in (("as stated", plain), ("offset unknown", free), ("half", half)):
        for share in (0.0, 0.25, 0.5, 1.0):
            rate = 1e3 * alarms(detector, white + share * offset)
            click.echo(f"  {name}: offset of {share:g} noises: {rate:.2f}")
        click.echo(f"  {name}: found {alarms(detector, pressed, 15):.1%}")
    for wrong in (0.9, 1.1, 1.2):
        click.echo(f"  noise {wrong:g} of the stated: {1e3 * alarms(plain, wrong * white):.2f}")
    for kept in (0.2, 0.5):  # of a reading's noise in the next, in 15 readings
        series = rng.normal(scale=NOISE, size=(COUNT, 72))
        total = series.copy()
        for _ in range(14):
            fresh = rng.normal(scale=NOISE * np.sqrt(1 - kept**2), size=(COUNT, 72))
            series = kept * series + fresh
            total += series
        told = sf.Detector(
            patch, LAYER, quantity=quantity, noise_std=NOISE, correlation=kept
        )  # fmt: skip
        rates = [1e3 * alarms(detector, total / 15, 15) for detector in (plain, told)]
        click.echo(f"  correlation {kept:g} in time: {rates[0]:.2f}, told of it {rates[1]:.2f}")
        pressed = light + (total / 15)[: len(light)]
        click.echo(f"    and found {alarms(told, pressed, 15):.1%}")


def times() -> None:
    """Print seconds to make a detector and a stream, and per reading."""
    patch, noise = sf.layouts.hexagon72(), np.random.default_rng(0).normal(size=(15, 72)) * NOISE
    for _ in range(2):  # the first loads what is compiled
        start = time.perf_counter()
        detector = sf.Detector(patch, LAYER, quantity=sf.BaseStress(), noise_std=NOISE)
        made = time.perf_counter()
        stream = detector.stream()
        streamed = time.perf_counter()
    click.echo(f"\n{len(detector.templates.readings)} templates")
    click.echo(f"made in {made - start:.2f} s, its stream in {streamed - made:.2f} s")
    laps = {"call": [], "update": []}  # type: dict[str, list[float]]
    for index in range(300):
        first = time.perf_counter()
        detector(noise)
        second = time.perf_counter()
        stream.update(noise[index % 15], index * 20_000_000)
        laps["call"].append(second - first)
        laps["update"].append(time.perf_counter() - second)
    for name, values in laps.items():
        click.echo(f"{name}: {np.median(values) * 1e3:.2f} ms, 99 %: "
                   f"{np.quantile(values, 0.99) * 1e3:.2f} ms")  # fmt: skip


if __name__ == "__main__":
    times()
    traps()
    rates(*(sys.argv[1:] or ["short"]))
