"""Layers that `calibrate.compare_layers` names in simulated worlds; a table of contacts.md.

    python benchmarks/compare_layers.py [--presses 100] [--sessions 20]

Random presses of `lab.case_sets` (balls, cones, flats, bars, rings, several at once) are solved in
each world; a session is twenty of them at random, one reading each. "with habits": gains of taxels
spread by 12 %, places by 0.3 mm, noise by a factor that is log-normal with 0.5.
"""

import argparse
from collections import Counter
from dataclasses import replace

import numpy as np

import skinfield as sf
from skinfield.calibrate import compare_layers
from skinfield.lab.case_sets import SILICONE, WORLDS, random_press

TOUCHES, NOISES, SEED = 20, (5e-4, 2e-3), 77
GAINS, PLACES, SPREAD = 0.12, 0.3e-3, 0.5
LAYERS = {
    "thinner (1.6 mm)": replace(SILICONE, thickness=1.6e-3),
    "thicker (2.5 mm)": replace(SILICONE, thickness=2.5e-3),
}
NAMES = ("as-stated", "nu-0.45", "nu-0.40", "cover", *LAYERS)


def pool(name: str, presses: int, habits: bool) -> np.ndarray:
    """Exact readings (P, L) of presses in a world, on one skin for all with habits."""
    patch = sf.layouts.hexagon72()
    world, layer = WORLDS.get(name, WORLDS["as-stated"]), LAYERS.get(name, SILICONE)
    off = PLACES * habits * np.random.default_rng(3).standard_normal(patch.plane.shape)
    made = []
    for index in range(presses):
        pressed = random_press(patch, index, SEED, layer, 0.3e-3, world)
        at = pressed.pose.taxels(patch.plane + off)
        made.append(pressed.press.readings(at, patch.pad_diameter, "capacitance"))
    return np.array(made)


def session(readings: np.ndarray, noise: float, habits: bool, seed: int) -> str:
    """What is named after one session; parts that read alike together."""
    rng = np.random.default_rng([6, seed])
    rows = readings[rng.permutation(len(readings))[:TOUCHES]]
    taxels = rows.shape[1]
    gain = np.exp(GAINS * habits * rng.standard_normal(taxels))
    std = noise * np.exp(SPREAD * habits * rng.standard_normal(taxels))
    made = compare_layers(
        sf.layouts.hexagon72(),
        gain * rows + std * rng.standard_normal(rows.shape),
        layer=SILICONE,
        noise_std=std,
    )
    return " or ".join(sorted(model.name for model in made.likely))


def main() -> None:
    """Print what is named in each world, and how often."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--presses", type=int, default=100)
    parser.add_argument("--sessions", type=int, default=20)
    how = parser.parse_args()
    for habits in (False, True):
        for name in NAMES:
            readings = pool(name, how.presses, habits)
            for noise in NOISES:
                said = (session(readings, noise, habits, seed) for seed in range(how.sessions))
                counts = ", ".join(f"{n} {what}" for what, n in Counter(said).most_common())
                print(name, "with habits" if habits else "", noise, counts, sep="; ", flush=True)


if __name__ == "__main__":
    main()
