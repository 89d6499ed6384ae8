"""Calibration by unknown touches on virtual skins: truth against what is found, as one table.

Plain skins: balls of any size press anywhere on the patch, one reading each. Real ones (`--habits
real`) are made within tolerances, pressed by balls and soft fingertips for a second each, and read
as counts of a board that is noisy, clips, rounds, drifts and jumps; the counts go the way of
`skinfield calibrate touch`. What taxels read is solved by `skinfield.simulate.press`, never by the
tables that are fitted.

    python benchmarks/touches.py                  # ten skins, some ten minutes
    python benchmarks/touches.py --habits real
    python benchmarks/touches.py --skins 2
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

import skinfield as sf
from skinfield.elastic import BaseStress, BondedLayer, Capacitance
from skinfield.errors import Floats, InputError
from skinfield.lab.habit_cases import FOAM
from skinfield.reconstruct.diagnostics import Conditioning, condition
from skinfield.simulate import Finger, Sphere, press
from skinfield.simulate.electronics import (
    CySkinBoard,
    cyskin_electronics,
    icub_electronics,
    recording,
)
from skinfield.simulate.electronics.noise import ROOM
from skinfield.simulate.habits import HABITS, NONE, REAL
from skinfield.simulate.pressing.press import readings_anywhere

PATCH = sf.layouts.hexagon72()
MODULUS = 150e3
KINDS, PRESSES = 16, 200
RADII, FORCES = (3e-3, 12e-3), (0.3, 3.0)
PASCAL = 2e5  # of base stress, as many as 1 of ΔC/C₀
RISE, HOLD, GAP, REST = 0.3, 1.0, 0.7, 5.0  # s
REAL_FORCES, REAL_PRESSES = (1.0, 8.0), 120
DEEPEST = 0.6  # of the thickness


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


@dataclass(frozen=True)
class Touched:
    """Readings (T, L) of touches and what is known of them; what is to be found."""

    readings: Floats
    noise: Floats | None
    stated: sf.Layer
    quantity: Capacitance | BaseStress
    true: sf.Layer
    covered: bool
    gain: Floats


def plain(number: int, seed: int) -> Touched:
    """Touches of a skin that is as `SKINS` says."""
    skin, rng = SKINS[number], np.random.default_rng([seed, number])
    layer = sf.Layer(skin.thickness, MODULUS, skin.poisson_ratio)
    kinds = []
    for _ in range(KINDS):
        radius, force = np.exp(rng.uniform(*np.log([RADII, FORCES]).T))
        ball = Sphere(radius=radius, force=force)
        made = press(layer, [ball], 24e-3, 0.4e-3, BondedLayer(skin.covered))
        quantity = "capacitance" if skin.capacitive else "stress"
        kinds.append(readings_anywhere(made, PATCH.pad_diameter, quantity))
    gain = np.exp(skin.gain_std * rng.standard_normal(len(PATCH)))
    where = rng.uniform(PATCH.plane.min(axis=0), PATCH.plane.max(axis=0), (PRESSES, 2))
    chosen = rng.integers(KINDS, size=PRESSES)
    each = np.array([kinds[k](PATCH.plane - at) for k, at in zip(chosen, where, strict=True)])
    noise = np.full(len(PATCH), skin.noise * (1.0 if skin.capacitive else PASCAL))
    readings = each * gain + noise * rng.standard_normal(each.shape)
    its = Capacitance() if skin.capacitive else BaseStress()
    return Touched(readings, noise, sf.Layer(), its, layer, skin.covered, gain)


def real(number: int, seed: int) -> Touched:
    """Touches of a skin with the habits of real ones: rubber or foam, two boards, covers."""
    making, pressing, clock, sending = np.random.default_rng([seed, number]).spawn(4)
    habits, covered = HABITS[REAL], number >= 6
    stated = FOAM if number % 2 else sf.Layer()
    layer, plane = habits.tolerances.layer(stated, making), habits.tolerances.plane(PATCH, making)
    if number % 4 < 2:
        board = CySkinBoard()
        usual = replace(
            cyskin_electronics(), board=replace(board, gain=board.convention.usual_gain)
        )
    else:
        usual = icub_electronics()
    skin = habits.electronics(usual).manufacture(PATCH, making)
    kinds = [_felt(layer, covered, habits.fingers[0], pressing) for _ in range(KINDS)]
    period = RISE + HOLD + RISE + GAP
    knots = (
        REST + np.cumsum([0.0, RISE, HOLD, RISE])[None] + period * np.arange(REAL_PRESSES)[:, None]
    )
    when = np.arange(0.0, REST + period * REAL_PRESSES, 5e-3)
    load = np.interp(when, knots.ravel(), np.tile([0.0, 1.0, 1.0, 0.0], REAL_PRESSES))
    assert habits.elastomer is not None
    load = habits.elastomer.effective_force(when, load)
    sampling = skin.sample_times(when[-1], clock)
    which = np.clip(((sampling.instants - REST) // period).astype(int), 0, REAL_PRESSES - 1)
    felt = np.empty((REAL_PRESSES, len(PATCH)))
    for row in range(REAL_PRESSES):
        at = PATCH.plane[pressing.integers(len(PATCH))] + PATCH.pitch * pressing.uniform(
            -0.5, 0.5, 2
        )
        turn = pressing.uniform(0.0, 2.0 * np.pi)
        turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        felt[row] = kinds[pressing.integers(KINDS)]((plane - at) @ turned)
    change = np.take_along_axis(felt, which, axis=0) * np.interp(sampling.instants, when, load)
    warm = ROOM + habits.warming * sampling.time
    sent = recording(skin, sampling, change, warm, sending)
    values = condition(sent, PATCH, stated, Capacitance(), Conditioning())[0]
    return Touched(values, None, stated, Capacitance(), layer, covered, np.abs(skin.gain))


def _felt(
    layer: sf.Layer, covered: bool, kind: Finger, rng: np.random.Generator
) -> Callable[[Floats], Floats]:
    """What a ball, or a fingertip of some size, makes taxels read around it."""
    size, force = np.exp(0.15 * rng.standard_normal()), np.exp(rng.uniform(*np.log(REAL_FORCES)))
    ball = Sphere(radius=np.exp(rng.uniform(*np.log(RADII))), force=1.0)
    finger = replace(kind, width=kind.width * size, length=(kind.length or kind.width) * size)
    body: Sphere | Finger = ball if rng.random() < 0.5 else finger
    while True:
        one = replace(body, force=float(force))
        extent = 2.0 * (one.reach + 12e-3) if isinstance(one, Finger) else 30e-3
        try:
            made = press(layer, [one], extent, 0.5e-3, BondedLayer(covered))
            if made.approach.max() <= DEEPEST * layer.thickness:
                return readings_anywhere(made, PATCH.pad_diameter, "capacitance", 0.5e-3)
        except InputError as error:
            if "sinks" not in str(error):
                raise
        force *= 0.7


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--skins", type=int, default=len(SKINS))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--habits", choices=(NONE, REAL), default=NONE)
    given = parser.parse_args()
    print("| reads, σ | truth: h mm, ν | found | gains before | after | stated | "
          "in 1, 2 deviations | presses, left out | s |")  # fmt: skip
    print("| --- " * 9 + "|")
    skin_off, gain_off = [], []
    for number in range(given.skins):
        its = (real if given.habits == REAL else plain)(number, given.seed)
        begun = time.perf_counter()
        made = sf.calibrate.touch(
            PATCH, its.readings, quantity=its.quantity, noise_std=its.noise, layer=its.stated,
            place_std=0.0 if given.habits == NONE else HABITS[REAL].tolerances.place_error,
        )  # fmt: skip
        took = time.perf_counter() - begun
        heard = np.isfinite(its.readings).any(axis=0)
        truth = np.log(its.gain[heard] / np.exp(np.log(its.gain[heard]).mean()))
        off, std = np.log(made.gain)[heard] - truth, (made.gain_std / made.gain)[heard]
        far = np.abs(off) / std
        gain_off.append(far)
        skin_off.append((made.thickness - its.true.thickness) / made.thickness_std)
        skin_off.append((made.poisson_ratio - its.true.poisson_ratio) / made.poisson_std)
        print(
            f"| {its.quantity.symbol}, {np.median(made.noise_std):.2g} | "
            f"{its.true.thickness * 1e3:.2f}, {its.true.poisson_ratio:.3f}"
            f"{', covered' * its.covered} | "
            f"{made.thickness * 1e3:.3f} ± {made.thickness_std * 1e3:.3f}, "
            f"{made.poisson_ratio:.4f} ± {made.poisson_std:.4f}{', covered' * made.covered} | "
            f"{truth.std():.1%} | {off.std():.1%} | {np.sqrt((std**2).mean()):.1%} | "
            f"{(far < 1).mean():.0%}, {(far < 1.96).mean():.0%} | "
            f"{made.presses}, {made.left_out} | {took:.0f} |\n    {made.verdict}",
            flush=True,
        )
    for name, each in (("gains", np.concatenate(gain_off)), ("layers", np.abs(skin_off))):
        print(f"{name}: {(each < 1).mean():.0%} within one deviation, {(each < 1.96).mean():.0%} "
              "within 1.96")  # fmt: skip


if __name__ == "__main__":
    main()
