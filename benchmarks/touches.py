"""Calibration by unknown touches on virtual skins: truth against what is found, as one table.

Balls of any size press anywhere on the patch. What taxels read of each is solved by
`skinfield.simulate.press`, never by the tables that are fitted.

    python benchmarks/touches.py            # ten skins, some ten minutes
    python benchmarks/touches.py --skins 2
"""

import argparse
import time
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

import skinfield as sf
from skinfield.elastic import BaseStress, BondedLayer, Capacitance
from skinfield.errors import Floats
from skinfield.simulate import Sphere, press

PATCH = sf.layouts.hexagon72()
MODULUS = 150e3
KINDS, PRESSES = 16, 200
RADII, FORCES = (3e-3, 12e-3), (0.3, 3.0)
PASCAL = 2e5  # of base stress, as many as 1 of ΔC/C₀


@dataclass(frozen=True)
class VirtualSkin:
    """What is to be found, and how it reads."""

    thickness: float
    poisson_ratio: float
    covered: bool
    gain_std: float
    noise: float
    capacitive: bool = True


SKINS = (
    VirtualSkin(2.3e-3, 0.47, False, 0.10, 0.0005),
    VirtualSkin(2.3e-3, 0.47, False, 0.10, 0.002),
    VirtualSkin(1.7e-3, 0.49, False, 0.12, 0.0005),
    VirtualSkin(1.8e-3, 0.46, False, 0.12, 0.002),
    VirtualSkin(3.0e-3, 0.43, False, 0.15, 0.0005),
    VirtualSkin(3.5e-3, 0.40, False, 0.10, 0.002),
    VirtualSkin(2.0e-3, 0.50, True, 0.10, 0.0005),
    VirtualSkin(2.6e-3, 0.48, True, 0.12, 0.002),
    VirtualSkin(2.3e-3, 0.47, False, 0.10, 0.0005, capacitive=False),
    VirtualSkin(2.0e-3, 0.45, False, 0.10, 0.002, capacitive=False),
)


def touched(skin: VirtualSkin, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Readings (T, L) of presses, and the gains (L,) of taxels."""
    layer = sf.Layer(skin.thickness, MODULUS, skin.poisson_ratio)
    far, kinds = np.linspace(0.0, 70e-3, 351), []
    quantity = "capacitance" if skin.capacitive else "stress"
    for _ in range(KINDS):
        radius, force = np.exp(rng.uniform(*np.log([RADII, FORCES]).T))
        ball = Sphere(radius=radius, force=force)
        made = press(layer, [ball], 24e-3, 0.4e-3, BondedLayer(skin.covered))
        places = np.column_stack([far, 0.0 * far])
        kinds.append(CubicSpline(far, made.readings(places, PATCH.pad_diameter, quantity)))
    gain = np.exp(skin.gain_std * rng.standard_normal(len(PATCH)))
    gain /= np.exp(np.log(gain).mean())
    where = rng.uniform(PATCH.plane.min(axis=0), PATCH.plane.max(axis=0), (PRESSES, 2))
    away = np.linalg.norm(PATCH.plane[None] - where[:, None], axis=2)
    chosen = rng.integers(KINDS, size=PRESSES)
    readings = np.array([kinds[k](each) for k, each in zip(chosen, away, strict=True)]) * gain
    return readings + noise_of(skin) * rng.standard_normal(readings.shape), gain


def noise_of(skin: VirtualSkin) -> float:
    """Deviation of one reading, in its unit."""
    return skin.noise * (1.0 if skin.capacitive else PASCAL)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--skins", type=int, default=len(SKINS))
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    print("| reads | σ | h mm, ν | found | gains spread | left | stated | in 1, 2 deviations | s |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    skin_off, gain_off = [], []
    for number, skin in enumerate(SKINS[: given.skins]):
        rng = np.random.default_rng([given.seed, number])
        readings, gain = touched(skin, rng)
        quantity = Capacitance() if skin.capacitive else BaseStress()
        begun = time.perf_counter()
        made = sf.calibrate.touch(PATCH, readings, quantity=quantity, noise_std=noise_of(skin))
        took = time.perf_counter() - begun
        off, std = np.log(made.gain / gain), made.gain_std / made.gain
        far = np.abs(off) / std
        gain_off.append(far)
        skin_off.append((made.thickness - skin.thickness) / made.thickness_std)
        skin_off.append((made.poisson_ratio - skin.poisson_ratio) / made.poisson_std)
        print(
            f"| {quantity.symbol} | {noise_of(skin):g} | {skin.thickness * 1e3:.2f}, "
            f"{skin.poisson_ratio:.2f}{', covered' * skin.covered} | "
            f"{made.thickness * 1e3:.3f} ± {made.thickness_std * 1e3:.3f}, "
            f"{made.poisson_ratio:.4f} ± {made.poisson_std:.4f}{', covered' * made.covered} | "
            f"{skin.gain_std:.0%} | {off.std():.1%} | {np.sqrt((std**2).mean()):.1%} | "
            f"{(far < 1).mean():.0%}, {(far < 1.96).mean():.0%} | {took:.0f} |",
            flush=True,
        )
    for name, each in (("gains", np.concatenate(gain_off)), ("layers", np.abs(skin_off))):
        print(f"{name}: {(each < 1).mean():.0%} within one deviation, {(each < 1.96).mean():.0%} "
              "within 1.96")  # fmt: skip


if __name__ == "__main__":
    main()
